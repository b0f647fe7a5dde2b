#pragma once
#include "Text/Query.h"

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
  NoMatch
};

struct SegmentAnswer {
  AnswerKind kind = AnswerKind::NoMatch;
  std::vector<SegmentCandidate> candidates; // best first
  std::size_t leading = 0;                  // how many of the first ones form the answer
  std::vector<std::string> structures; // how the query was understood, as names of structures; empty: not
  std::string sentence;                // the answer for a person
};

/// Finds a scene's segments by the words that people use: first by the segments' own names, then by the
/// lexicon.
class SegmentSearch {
public:
  /// Throws Error(InvalidArgument) if a segment has no name.
  SegmentSearch(const Lexicon& lexicon, std::vector<NamedSegment> segments);

  /// Throws Error(InvalidArgument) like interpret().
  SegmentAnswer find(std::string_view query) const;

private:
  struct Entry {
    std::vector<std::string> words;
    Structures structures; // the lexicon's meaning of the name; empty: none
  };
  std::vector<SegmentCandidate> byName(const std::vector<std::string>& words) const;

  const Lexicon& lexicon_;
  std::vector<NamedSegment> segments_;
  std::vector<Entry> entries_;
};

} // namespace innergs
