#pragma once
#include "Core/Features/ClassProbabilities.h"
#include "Text/SegmentSearch.h"
#include "Text/SegmentedModel.h"

#include <array>
#include <optional>

namespace innergs {

/// What a segment is called, and its colour.
struct SegmentTerms {
  std::string name;
  std::string code, meaning;                  // SNOMED CT; empty: not known
  Side side = Side::None;                     // of the coded structure
  std::array<double, 3> color{0.5, 0.7, 0.5}; // red, green, blue from 0 to 1
};

/// The lexicon's terms for a name. index: of the segment; those that follow each other get colours far apart.
SegmentTerms termsOf(const Lexicon& lexicon, const std::string& name, int index);

/// The entry of 3D Slicer's terminologies ("DICOM master list") for a segment, as Slicer serialises it; ""
/// without a code.
std::string terminologyEntry(const SegmentTerms& terms);

/// A segment that a query asks for.
struct RequestedSegment {
  SegmentTerms terms;
  std::vector<int> classes; // of the model; the segment holds all of them
};

/// Segments of one grid, ready to be shown or kept.
struct MadeSegments {
  GridGeometry grid; // of which each segment is a part
  std::vector<std::pair<SegmentTerms, Segment>> segments;
};

/// Finds the segments of a model with features by what a person calls them, on one grid.
class SegmentFinder {
public:
  /// Throws Error(NoData) for a model without features.
  explicit SegmentFinder(SegmentedModel model);

  /// Decodes the features at every voxel of a grid, once: seconds for a whole volume. Queries after it
  /// take milliseconds and know which structures the volume does not show. Does nothing if the grid is the
  /// same as before. Throws Error(Geometry | Memory | Cancelled).
  void encode(const GridGeometry& geometry, const FeatureQueryOptions& options = {});
  /// Null before encode().
  const ClassProbabilities* probabilities() const { return probabilities_ ? &*probabilities_ : nullptr; }

  /// The grid of the region that was fitted.
  const GridGeometry& region() const { return model_.field->region(); }
  /// The name of a candidate's segment.
  const std::string& nameOf(const SegmentCandidate& candidate) const;

  /// Throws Error(InvalidArgument) as interpret() does.
  SegmentAnswer find(std::string_view query) const { return search_->find(query); }
  /// What the answer to a query asks for: the leading candidates as one segment or, where side or number is
  /// open, one each; none where nothing was found.
  std::vector<RequestedSegment> requested(std::string_view query, const SegmentAnswer& answer) const;
  /// Requested segments on the encoded grid. Throws Error(InvalidArgument) before encode() and as
  /// ClassProbabilities::segment() does.
  MadeSegments make(const std::vector<RequestedSegment>& requested, const SegmentOptions& options = {},
                    const std::stop_token& stop = {}) const;
  /// The request for one candidate alone.
  RequestedSegment requested(const SegmentCandidate& candidate) const;

private:
  void makeSearch();

  SegmentedModel model_; // for a dynamic scan, with its field at the time
  std::optional<ClassProbabilities> probabilities_;
  std::optional<SegmentSearch> search_;
};

} // namespace innergs
