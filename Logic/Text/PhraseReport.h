#pragma once
#include "Text/Lexicon.h"

#include <string>
#include <vector>

namespace innergs {

/// A phrase and the structures that it means; none: it must not match.
struct Phrase {
  std::string text, kind;          // kind: "lay", "latin", "typo", "near", …
  std::vector<std::string> expect; // names of structures, e.g. "rib_left_7"
};

/// A set of phrases and the names of the scene's segments that they are asked in.
struct PhraseSet {
  std::vector<Phrase> phrases;
  std::vector<std::string> scene;
};

/// From a file of Resources/Terminology: the scene has a segment of every structure of the lexicon but those
/// of the concepts that the file calls absent; "*" in what is expected stands for any characters of its
/// names. Throws Error(FileFormat).
PhraseSet phrasesFrom(const Lexicon& lexicon, std::string_view json);

/// How queries fare on a set of phrases.
struct PhraseReport {
  int named = 0, foreign = 0;      // phrases that mean a structure, and that must not match
  int top1 = 0;                    // the leading candidates are exactly the structures meant
  int top3 = 0;                    // these are among the first three candidates, or as many as are meant
  int wrong = 0;                   // the leading candidates hold none of the structures meant
  int flipped = 0;                 // of these: the right kind, the other side
  int falseAccepts = 0;            // of the foreign: a structure was given
  double milliseconds = 0;         // a phrase, on average
  std::vector<std::string> misses; // "text: what was given", for people
};
PhraseReport reportOn(const Lexicon& lexicon, const PhraseSet& set);

} // namespace innergs
