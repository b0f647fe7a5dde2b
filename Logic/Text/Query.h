#pragma once
#include "Text/Lexicon.h"

namespace innergs {

/// One reading of a text: the structures it asks for; all candidates if it names no side or number.
struct Interpretation {
  Structures structures;
  double score = 0; // 1: exactly as in the lexicon; less for every typing error
};

/// The possible readings of a text, best first, with each set of structures once. Every word must be
/// understood: a text that says more than a structure, its side and its number ("liver mass", "T2 weighted
/// liver") has no reading. Empty: none. Throws Error(InvalidArgument) for a text of more than 300 bytes or
/// without a letter or digit.
std::vector<Interpretation> interpret(const Lexicon& lexicon, std::string_view text);

} // namespace innergs
