#pragma once
#include "Text/Query.h"
#include "Text/SentenceEmbedding.h"

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace innergs {

/// A segment of a scene, as seen by a query.
struct NamedSegment {
  std::string name;    // as the user or a tool gave it: "kidney_left", "Left kidney", "Tumor 2"
  bool present = true; // it has voxels in this volume
};

struct SegmentCandidate {
  int segment = -1;   // index into the scene's segments
  double score = 0;   // 0 to 1
  bool wider = false; // the segment contains more than requested ("kidneys" for "left kidney")
};

enum class AnswerKind {
  Found,       // the leading candidates together are the answer
  Several,     // side or number is open: the leading candidates, for a person to choose from
  Wider,       // only segments that contain the requested structure and more
  NotInVolume, // a known structure, but no segment of the scene has a voxel of it
  NoMatch,
  Similar // words that the lexicon does not know: the candidates are near in meaning, for a person to choose
          // from; none of them leads
};

struct SegmentAnswer {
  AnswerKind kind = AnswerKind::NoMatch;
  std::vector<SegmentCandidate> candidates; // best first
  std::size_t leading = 0;                  // how many of the first ones form the answer
  std::vector<std::string> structures; // how the query was understood, as names of structures; empty: not
  std::string sentence;                // the answer for a person
  std::string note; // with NoMatch: why no sentence embedding was asked; "": one was, or could not help
};

class SimilarSegments;

/// Finds a scene's segments by the words that people use: first by the segments' own names, then by the
/// lexicon, and words that are in neither by a sentence embedding, if there is one.
class SegmentSearch {
public:
  /// Throws Error(InvalidArgument) if a segment has no name.
  /// sentences: asked at the first query that needs it; null: never.
  SegmentSearch(const Lexicon& lexicon, std::vector<NamedSegment> segments,
                std::function<SentenceModel()> sentences = nullptr);
  ~SegmentSearch();
  SegmentSearch(SegmentSearch&&) noexcept;

  /// Throws Error(InvalidArgument) like interpret().
  /// One thread at a time.
  SegmentAnswer find(std::string_view query) const;

private:
  struct Entry {
    std::vector<std::string> words;
    Structures structures; // the lexicon's meaning of the name; empty: none
  };
  std::vector<SegmentCandidate> byName(const std::vector<std::string>& words) const;
  void addSimilar(std::string_view query, SegmentAnswer& answer) const;

  const Lexicon& lexicon_;
  std::vector<NamedSegment> segments_;
  std::vector<Entry> entries_;
  std::function<SentenceModel()> sentences_;
  mutable std::unique_ptr<SimilarSegments> similar_;     // made at the first query that needs it
  mutable std::shared_ptr<SentenceEmbedding> embedding_; // that it was made with
};

} // namespace innergs
