#pragma once
#include "Core/Features/FeatureQuery.h"

#include <array>

namespace innergs {

/// Which voxels make a segment.
struct SegmentOptions {
  double threshold = 0;     // with at least this probability; 0: where the segment is the likeliest
  double smoothing = 0;     // standard deviation of a Gaussian that smooths before that, mm
  bool largestOnly = false; // only the largest connected part
  double minimumSize = 0;   // of a connected part, mm³
};

/// A part of a grid, and which of its voxels are inside a segment.
struct Segment {
  std::array<std::int64_t, 3> first{0, 0, 0}; // its first voxel on the whole grid
  GridGeometry geometry;                      // of the part; no voxel where the segment is nowhere
  std::vector<std::uint8_t> mask;             // 1 inside
  std::vector<float> probability;             // before smoothing; 0 outside the part
  std::int64_t voxels = 0;                    // inside
};

/// Calls each(voxel of the whole grid, voxel of the segment's part), both in memory order, for every voxel
/// of the part; whole: the grid's size.
template <class Each>
void forEachVoxel(const Segment& segment, const std::array<std::int64_t, 3>& whole, Each&& each) {
  const auto& n = segment.geometry.size;
  std::size_t at = 0;
  for (std::int64_t k = 0; k < n[2] && !segment.mask.empty(); ++k)
    for (std::int64_t j = 0; j < n[1]; ++j) {
      const std::int64_t row =
          segment.first[0] + whole[0] * (segment.first[1] + j + whole[1] * (segment.first[2] + k));
      for (std::int64_t i = 0; i < n[0]; ++i, ++at)
        each(static_cast<std::size_t>(row + i), at);
    }
}

/// The probabilities of a model's classes on a grid, encoded once: a query then reads only the voxels of
/// the classes that it asks for.
class ClassProbabilities {
public:
  /// Throws Error(Geometry | Memory | Cancelled).
  ClassProbabilities(const GaussianField& field, const FeatureModel& features, const GridGeometry& geometry,
                     const FeatureQueryOptions& options = {});

  const GridGeometry& geometry() const { return geometry_; }
  /// Voxels where a class is the likeliest.
  std::int64_t voxels(int c) const { return lists_[static_cast<std::size_t>(c)].likeliest; }
  std::int64_t bytes() const;

  /// The segment that some classes make together. Throws Error(InvalidArgument) for options out of range or
  /// an unknown class, Error(Cancelled).
  Segment segment(std::span<const int> classes, const SegmentOptions& options = {},
                  const std::stop_token& stop = {}) const;

private:
  struct List { // of a class's voxels
    std::vector<std::uint32_t> voxels;
    std::vector<std::uint16_t> shares; // probability × 32767; the highest bit: the likeliest
    std::int64_t likeliest = 0;
    std::array<std::int64_t, 3> low{}, high{}; // box of the voxels, both inclusive
  };
  GridGeometry geometry_;
  std::vector<List> lists_; // per class; that of the background is empty
};

} // namespace innergs
