#pragma once
#include "Text/SegmentSearch.h"

namespace innergs {

/// The segments of a scene that are nearest in meaning to words which the lexicon does not know.
class SimilarSegments {
public:
  /// The least cosine of a suggestion by all-MiniLM-L6-v2: above what words without an anatomical meaning
  /// reach (Docs/method.md).
  static constexpr double kLeastCosine = 0.48;
  static constexpr std::size_t kMost = 10;

  /// structures: per segment, what its name means to the lexicon; empty: nothing.
  SimilarSegments(const Lexicon& lexicon, const std::vector<NamedSegment>& segments,
                  const std::vector<Structures>& structures, SentenceEmbedding& embedding);

  /// Segments with a cosine of at least kLeastCosine, best first. Words for a side are not part of the
  /// meaning: they exclude segments of the other side.
  std::vector<SegmentCandidate> find(std::string_view query, SentenceEmbedding& embedding) const;

private:
  struct Entry {
    int segment = 0;
    Side side = Side::None;
    std::vector<std::size_t> phrases;
  };
  std::string withoutSide(const std::vector<std::string>& words) const;

  const Lexicon& lexicon_;
  std::vector<Entry> entries_;               // of the segments that are present
  std::vector<std::vector<float>> meanings_; // per phrase
};

} // namespace innergs
