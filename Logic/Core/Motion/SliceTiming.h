#pragma once
#include <cstdint>
#include <vector>

namespace innergs {

struct GridGeometry;

/// When the slices of a frame were acquired, if not all at once.
struct SliceTiming {
  int axis = 2;              // grid axis that counts the slices
  std::vector<double> times; // s after the frame's time, of each slice along the axis; empty: all at once

  bool empty() const { return times.empty(); }
  bool operator==(const SliceTiming&) const = default;
};

/// Slices that were acquired together.
struct SliceGroups {
  std::vector<double> times; // s after the frame's time, of each group; {0} without a timing
  std::vector<int> ofSlice;  // the group of each slice
  std::int64_t step = 1;     // voxels from one slice to the next
  std::int64_t slices = 1;

  int of(std::int64_t voxel) const { return ofSlice[voxel / step % slices]; }

  /// Calls run(begin, end, group) for the runs of voxels [first, last) that belong to one group.
  template <class Run>
  void runs(std::int64_t first, std::int64_t last, const Run& run) const {
    while (first < last) {
      const int group = of(first);
      std::int64_t end = first;
      do
        end += step - end % step;
      while (end < last && of(end) == group);
      run(first, end < last ? end : last, group);
      first = end;
    }
  }
};

SliceGroups sliceGroups(const SliceTiming& timing, const GridGeometry& geometry);

} // namespace innergs
