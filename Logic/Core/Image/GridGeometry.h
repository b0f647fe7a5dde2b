#pragma once
#include "Core/Image/Linear.h"

#include <cstdint>
#include <string>

namespace innergs {

/// A regular voxel grid in patient space, with ITK's conventions: LPS millimetres; the columns of
/// `direction` are the unit IJK axes (left-handed grids allowed). The centre of voxel (i,j,k) is origin +
/// direction·(spacing∘(i,j,k)).
struct GridGeometry {
  std::array<std::int64_t, 3> size{0, 0, 0}; // voxels along I, J, K; I runs fastest in memory
  Vec3 origin{0, 0, 0};                      // mm
  Vec3 spacing{1, 1, 1};                     // mm
  Mat3 direction;

  std::int64_t voxelCount() const { return size[0] * size[1] * size[2]; }
  Affine3 indexToWorld() const { return {direction * diagonal(spacing), origin}; }
  Vec3 centre() const;                 // mm
  Vec3 extent() const;                 // size × spacing, mm
  double finestSpacing() const;        // of the three, mm
  std::array<Vec3, 8> corners() const; // of its box, voxel edge to voxel edge, mm
  bool operator==(const GridGeometry&) const = default;
};

/// Throws Error(Geometry) for an empty grid, a spacing that is not finite and positive, or a direction
/// that is not orthonormal to 1e-3 (sheared or singular). `what` names the image in the message.
void checkGeometry(const GridGeometry& geometry, const std::string& what);

/// The grid over the same box (voxel edge to voxel edge) at another spacing (mm), with the same centre.
/// Throws Error(InvalidArgument) for a spacing not above 0 or more than 100,000 voxels along an axis.
GridGeometry withSpacing(const GridGeometry& geometry, const Vec3& spacing);

/// The grid over the same box, resampled so that no axis has more than `most` voxels.
GridGeometry reduced(const GridGeometry& geometry, std::int64_t most);

/// The grid cropped to the index range [first, first+size), at the same patient position.
GridGeometry cropped(const GridGeometry& geometry, const std::array<std::int64_t, 3>& first,
                     const std::array<std::int64_t, 3>& size);

/// From a continuous index to the nearest face of the grid's box (mm), negative outside.
double depthInside(const GridGeometry& geometry, const Vec3& index);

/// True if the sizes agree and all corner voxels coincide within `tolerance` mm.
bool sameGrid(const GridGeometry& a, const GridGeometry& b, double tolerance = 1e-3);

} // namespace innergs
