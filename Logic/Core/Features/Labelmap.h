#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <vector>

namespace innergs {

/// An image of labels, 0 the background; memory order of Volume.
struct Labelmap {
  GridGeometry geometry;
  std::vector<std::uint16_t> voxels;
  std::vector<std::uint8_t> labelled; // per slice along K: 1 where somebody labelled it; empty: all of them

  bool isLabelled(std::int64_t k) const { return labelled.empty() || labelled[static_cast<std::size_t>(k)]; }
};

/// An image's values as labels. Throws Error(FileFormat) for values that are no labels from 0 to 65535.
Labelmap labelmapOf(const Volume& volume);

/// A labelmap whose slices between labelled ones hold no label at all, along one axis: that axis becomes K,
/// and those slices count as not labelled. Any other labelmap as it is, all of its slices labelled.
Labelmap withSparseSlices(const Labelmap& labels);

/// Nearest neighbour through patient space, 0 outside.
Labelmap resampled(const Labelmap& labels, const GridGeometry& geometry);

} // namespace innergs
