#pragma once
#include "Core/Image/GridGeometry.h"

#include <span>
#include <stop_token>
#include <vector>

namespace innergs {

/// A scalar image: voxels[i + size[0]·(j + size[1]·k)], in the scanner's own units.
struct Volume {
  GridGeometry geometry;
  std::vector<float> voxels;
};

/// A binary image: 1 inside. Same memory order as Volume.
struct Mask {
  GridGeometry geometry;
  std::vector<std::uint8_t> voxels;
};

/// Smallest and largest value, in scanner units.
struct ValueRange {
  float low = 0, high = 0;
};

/// Trilinear value at a continuous index, clamped to the lattice's edge.
float sampleLinear(const Volume& volume, const Vec3& index);

/// The same image with lattice axis `axis` (0 = I, 1 = J, 2 = K) moved to K; the other two keep their order,
/// and every voxel its patient position.
Volume withSliceAxis(const Volume& volume, int axis);
Mask withSliceAxis(const Mask& mask, int axis);
GridGeometry withSliceAxis(const GridGeometry& geometry, int axis);
/// The former lattice axes in their new order. Throws Error(InvalidArgument) for an axis other than 0, 1, 2.
std::array<int, 3> axesWithSliceAxis(int axis);

/// The same where the index lies within the lattice's box of voxel edges; false and untouched outside.
/// `voxels`: in memory order of the lattice.
bool sampleInside(const GridGeometry& geometry, const float* voxels, const Vec3& index, float& value);

/// The mask on another lattice: nearest neighbour through patient space, 0 outside. Throws Error(Cancelled).
std::vector<std::uint8_t> resampleMask(const Mask& mask, const GridGeometry& geometry,
                                       const std::stop_token& stop = {});

} // namespace innergs
