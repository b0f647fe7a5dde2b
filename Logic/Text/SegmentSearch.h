#pragma once
#include "Text/Query.h"

#include <string>
#include <vector>

namespace innergs {

/// A segment of a scene, as a query sees it.
struct NamedSegment {
  std::string name;    // as the user or a tool gave it: "kidney_left", "Left kidney", "Tumor 2"
  bool present = true; // it has voxels in this volume
};

struct SegmentCandidate {
  int segment = -1;   // index into the scene's segments
  double score = 0;   // 0 to 1
  bool wider = false; // the segment holds more than was asked for ("kidneys" for "left kidney")
};

enum class AnswerKind {
  Found,       // the leading candidates together are what was asked for
  Several,     // side or number is open: any of the leading candidates, for a person to choose
  Wider,       // only segments that hold what was asked for and more
  NotInVolume, // a known structure, but no segment of the scene has a voxel of it
  NoMatch
};

struct SegmentAnswer {
  AnswerKind kind = AnswerKind::NoMatch;
  std::vector<SegmentCandidate> candidates; // best first
  std::size_t leading = 0;                  // how many at the front answer the query together
  std::vector<std::string> structures; // what the query was understood as, as names of structures; empty: not
  std::string sentence;                // the answer for a person
};

/// Finds a scene's segments by what a person calls them: first by the segments' own names, then by the
/// lexicon.
class SegmentSearch {
public:
  /// Throws Error(InvalidArgument) where a segment has no name.
  SegmentSearch(const Lexicon& lexicon, std::vector<NamedSegment> segments);

  /// Throws Error(InvalidArgument) as interpret() does.
  SegmentAnswer find(std::string_view query) const;

private:
  struct Entry {
    std::vector<std::string> words;
    Structures structures; // what the name means to the lexicon; empty: nothing
  };
  std::vector<SegmentCandidate> byName(const std::vector<std::string>& words) const;

  const Lexicon& lexicon_;
  std::vector<NamedSegment> segments_;
  std::vector<Entry> entries_;
};

} // namespace innergs
