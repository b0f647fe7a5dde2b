#pragma once
#include "Core/Image/Stack.h"

#include <optional>

namespace innergs {

/// An axis-aligned box in patient space (LPS mm).
struct Region {
  Vec3 min{0, 0, 0}, max{0, 0, 0};
};

/// The smallest block of the lattice that covers the region, grown by `margin` mm; for an oblique lattice it
/// reaches beyond the region's faces. Throws Error(InvalidArgument) for an inverted region, Error(Geometry)
/// when they do not meet.
GridGeometry cropped(const GridGeometry& geometry, const Region& region, double margin = 0);

/// A box turned in space, as a lattice of one voxel (LPS): the box is its cell. The same for an axis-aligned
/// one.
GridGeometry boxOf(const Region& region);
/// The box with every face `margin` mm further out.
GridGeometry grown(const GridGeometry& box, double margin);
/// The smallest block of the lattice that covers a turned box, grown by `margin` mm. Throws as above.
GridGeometry cropped(const GridGeometry& geometry, const GridGeometry& box, double margin = 0);
/// Whether the box's faces are parallel to the lattice's: then the block holds nothing but the box.
bool parallel(const GridGeometry& geometry, const GridGeometry& box);

/// The box of a lattice, voxel edge to voxel edge, as such a lattice of one voxel.
GridGeometry boxOf(const GridGeometry& lattice);

/// A block of a lattice's voxels.
struct IndexBlock {
  std::array<std::int64_t, 3> first, size;
};
/// The smallest that covers a turned box; nothing when they do not meet.
std::optional<IndexBlock> blockOver(const GridGeometry& geometry, const GridGeometry& box);

/// The part of a stack that covers the region, grown by `margin` mm; slice poses are respected.
Stack cropped(const Stack& stack, const Region& region, double margin = 0);

} // namespace innergs
