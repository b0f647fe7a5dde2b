#pragma once
#include "Core/Image/GridGeometry.h"

#include <span>
#include <stop_token>
#include <vector>

namespace innergs {

/// A scalar image: voxels[i + size[0]·(j + size[1]·k)], in scanner units.
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

/// Trilinear interpolation at a continuous index, clamped to the grid.
float sampleLinear(const Volume& volume, const Vec3& index);

/// The same image with grid axis `axis` (0 = I, 1 = J, 2 = K) moved to K; the other two keep their order,
/// and every voxel its position in the patient.
Volume withSliceAxis(const Volume& volume, int axis);
Mask withSliceAxis(const Mask& mask, int axis);
GridGeometry withSliceAxis(const GridGeometry& geometry, int axis);
/// The original grid axes in their new order. Throws Error(InvalidArgument) unless axis is 0, 1 or 2.
std::array<int, 3> axesWithSliceAxis(int axis);

/// Like sampleLinear(), where the index lies inside the grid's box of voxel edges; outside, returns false
/// and leaves `value` alone. `voxels`: in the grid's memory order.
bool sampleInside(const GridGeometry& geometry, const float* voxels, const Vec3& index, float& value);

/// The mask resampled to another grid: nearest neighbour, 0 outside. Throws Error(Cancelled) when stopped.
std::vector<std::uint8_t> resampleMask(const Mask& mask, const GridGeometry& geometry,
                                       const std::stop_token& stop = {});

} // namespace innergs
