#pragma once
#include "Core/Image/Stack.h"

#include <algorithm>
#include <concepts>
#include <optional>

namespace innergs {

/// An axis-aligned box in patient space (LPS mm).
struct Region {
  Vec3 min{0, 0, 0}, max{0, 0, 0};
};

/// The smallest block of the grid that covers the region grown by `margin` mm; on an oblique grid it
/// extends beyond the region's faces. Throws Error(InvalidArgument) for an inverted region and
/// Error(Geometry) if the two do not overlap.
GridGeometry cropped(const GridGeometry& geometry, const Region& region, double margin = 0);

/// An axis-aligned region as an oriented box: a grid of one voxel (LPS) whose cell is the box.
GridGeometry boxOf(const Region& region);
/// The box with every face moved outwards by `margin` mm.
GridGeometry grown(const GridGeometry& box, double margin);
/// The smallest block of the grid that covers an oriented box grown by `margin` mm. Throws as above.
GridGeometry cropped(const GridGeometry& geometry, const GridGeometry& box, double margin = 0);
/// Whether the box's faces are parallel to the grid's: then the block covers exactly the box, up to whole
/// voxels.
bool parallel(const GridGeometry& geometry, const GridGeometry& box);

/// A grid's box, voxel edge to voxel edge, as a grid of one voxel.
GridGeometry boxOf(const GridGeometry& grid);

/// A block of a grid's voxels.
struct IndexBlock {
  std::array<std::int64_t, 3> first, size;
};
/// The smallest block that covers an oriented box; nothing if they do not overlap.
std::optional<IndexBlock> blockOver(const GridGeometry& geometry, const GridGeometry& box);
/// The smallest block that holds every voxel v, counted from 0, for which holds(v), of a grid of this
/// size; nothing if there is none.
template <std::predicate<std::size_t> Holds>
std::optional<IndexBlock> filledBlock(const std::array<std::int64_t, 3>& size, const Holds& holds) {
  std::array<std::int64_t, 3> low = size, high{-1, -1, -1};
  std::size_t row = 0;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j, row += size[0]) {
      std::int64_t first = 0, last = size[0] - 1;
      while (first <= last && !holds(row + first))
        ++first;
      if (first > last) continue;
      while (!holds(row + last))
        --last;
      low = {std::min(low[0], first), std::min(low[1], j), std::min(low[2], k)};
      high = {std::max(high[0], last), std::max(high[1], j), k};
    }
  if (high[2] < 0) return {};
  return IndexBlock{low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1}};
}
/// The smallest block that holds every voxel that is not 0.
std::optional<IndexBlock> filledBlock(const std::array<std::int64_t, 3>& size,
                                      std::span<const std::uint8_t> voxels);

/// The part inside a block.
Volume cropped(const Volume& volume, const IndexBlock& block);
Mask cropped(const Mask& mask, const IndexBlock& block);

/// The part of a stack that covers the region grown by `margin` mm; respects slice poses.
Stack cropped(const Stack& stack, const Region& region, double margin = 0);

} // namespace innergs
