#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <vector>

namespace innergs {

/// An image of labels, 0 for the background; memory order of Volume.
struct Labelmap {
  GridGeometry geometry;
  std::vector<std::uint16_t> voxels;
  std::vector<std::uint8_t> labelled; // per slice along K: 1 if it was labelled; empty: all of them

  bool isLabelled(std::int64_t k) const { return labelled.empty() || labelled[static_cast<std::size_t>(k)]; }
};

/// An image's values as labels. Throws Error(FileFormat) for values other than whole numbers from 0 to 65535.
Labelmap labelmapOf(const Volume& volume);

/// If slices between labelled ones, along one axis, contain no label at all, that axis becomes K and those
/// slices count as unlabelled. Any other labelmap is unchanged, with all slices labelled.
Labelmap withSparseSlices(const Labelmap& labels);

/// Resamples by nearest neighbour in patient space, 0 outside.
Labelmap resampled(const Labelmap& labels, const GridGeometry& geometry);

} // namespace innergs
