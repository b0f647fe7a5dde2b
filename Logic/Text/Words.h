#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace innergs {

/// A text (UTF-8) as words of lower-case ASCII letters and digits: accents and punctuation dropped, "_" and
/// camel case ("LeftKidney") apart, "patient's" as "patients", "l'aorte" as "aorte".
std::vector<std::string> wordsOf(std::string_view text);

/// An English plural's singular, by its ending; any other word as it is.
std::string singular(const std::string& word);

/// Insertions, deletions, substitutions and swaps of neighbours that make one word the other (Damerau 1964,
/// optimal string alignment); limit + 1 when there are more than `limit`.
int editDistance(std::string_view a, std::string_view b, int limit);

} // namespace innergs
