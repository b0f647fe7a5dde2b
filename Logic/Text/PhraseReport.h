#pragma once
#include "Text/Lexicon.h"
#include "Text/SentenceEmbedding.h"

#include <memory>
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
  int named = 0, foreign = 0; // phrases that mean a structure, and that must not match
  int top1 = 0;               // the leading candidates are exactly the structures meant
  int top3 = 0;    // these are among the first three candidates, suggestions too, or as many as are meant
  int wrong = 0;   // the leading candidates include none of the structures meant
  int flipped = 0; // among them: the right kind on the wrong side
  int falseAccepts = 0;            // of the foreign phrases: a structure was returned
  int unanswered = 0;              // phrases that mean a structure, and none was returned
  int suggested = 0;               // among them: what is meant is among the first three suggestions
  int foreignSuggested = 0;        // of the foreign phrases: something was suggested
  double milliseconds = 0;         // median per phrase
  double unread = 0;               // median, ms, of those beyond the lexicon
  double slowest = 0;              // ms; with an embedding, it encodes the names of the scene
  std::vector<std::string> misses; // "text: result", for reading
};
/// embedding: for suggestions; null: none are made.
PhraseReport reportOn(const Lexicon& lexicon, const PhraseSet& set,
                      std::shared_ptr<SentenceEmbedding> embedding = nullptr);

} // namespace innergs
