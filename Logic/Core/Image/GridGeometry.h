#pragma once
#include "Core/Image/Linear.h"

#include <cstdint>
#include <string>

namespace innergs {

/// A regular voxel lattice in patient space, as ITK has it: LPS millimetres, direction columns are the unit
/// IJK axes (left-handed lattices allowed). Voxel (i,j,k) has its centre at origin +
/// direction·(spacing∘(i,j,k)).
struct GridGeometry {
  std::array<std::int64_t, 3> size{0, 0, 0}; // voxels along I, J, K; I runs fastest in memory
  Vec3 origin{0, 0, 0};                      // mm
  Vec3 spacing{1, 1, 1};                     // mm
  Mat3 direction;

  std::int64_t voxelCount() const { return size[0] * size[1] * size[2]; }
  Affine3 indexToWorld() const { return {direction * diagonal(spacing), origin}; }
  Vec3 centre() const; // mm
  Vec3 extent() const; // size × spacing, mm
  bool operator==(const GridGeometry&) const = default;
};

/// Throws Error(Geometry) for an empty lattice, a spacing that is not finite and positive, or a direction
/// that is not orthonormal to 1e-3 (sheared or singular). `what` names the image in the sentence.
void checkGeometry(const GridGeometry& geometry, const std::string& what);

/// The lattice that covers the same box (voxel edge to voxel edge) at another spacing (mm), centred on it.
GridGeometry withSpacing(const GridGeometry& geometry, const Vec3& spacing);

/// The lattice cut to index range [first, first+size), in the same patient position.
GridGeometry cropped(const GridGeometry& geometry, const std::array<std::int64_t, 3>& first,
                     const std::array<std::int64_t, 3>& size);

/// True when sizes agree and every corner voxel lies within `tolerance` mm.
bool sameLattice(const GridGeometry& a, const GridGeometry& b, double tolerance = 1e-3);

} // namespace innergs
