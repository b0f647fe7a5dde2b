#pragma once
#include "Text/Lexicon.h"

#include <string>
#include <vector>

namespace innergs {

/// A phrase and the structures that it means; if empty, it must not match.
struct Phrase {
  std::string text, kind;          // kind: "lay", "latin", "typo", "near", …
  std::vector<std::string> expect; // names of structures, e.g. "rib_left_7"
};

/// A set of phrases, with the names of the segments in the scene that they are queried in.
struct PhraseSet {
  std::vector<Phrase> phrases;
  std::vector<std::string> scene;
};

/// Reads a file of Resources/Terminology: the scene has a segment of every structure in the lexicon, except
/// those of the concepts that the file lists as absent; "*" in the expected names matches any characters.
/// Throws Error(FileFormat).
PhraseSet phrasesFrom(const Lexicon& lexicon, std::string_view json);

/// Results of queries on a set of phrases.
struct PhraseReport {
  int named = 0, foreign = 0;      // phrases that mean a structure, and that must not match
  int top1 = 0;                    // the leading candidates are exactly the structures meant
  int top3 = 0;                    // these are among the first three candidates, or as many as are meant
  int wrong = 0;                   // the leading candidates include none of the structures meant
  int flipped = 0;                 // of these: the right kind on the wrong side
  int falseAccepts = 0;            // of the foreign phrases: a structure was returned
  double milliseconds = 0;         // average per phrase
  std::vector<std::string> misses; // "text: result", for reading
};
PhraseReport reportOn(const Lexicon& lexicon, const PhraseSet& set);

} // namespace innergs
