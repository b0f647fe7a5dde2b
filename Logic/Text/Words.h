#pragma once
#include <string>
#include <string_view>
#include <vector>

namespace innergs {

/// Splits a text (UTF-8) into words of lower-case ASCII letters and digits: drops accents and punctuation,
/// splits at "_" and camel case ("LeftKidney"), and turns "patient's" into "patients", "l'aorte" into
/// "aorte".
std::vector<std::string> wordsOf(std::string_view text);

/// The singular of an English plural, by its ending; other words are unchanged.
std::string singular(const std::string& word);

/// Insertions, deletions, substitutions and swaps of neighbours that turn one word into the other (Damerau
/// 1964, optimal string alignment); limit + 1 if there are more than `limit`.
int editDistance(std::string_view a, std::string_view b, int limit);

} // namespace innergs
