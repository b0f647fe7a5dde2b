#pragma once
#include "Core/Image/Volume.h"

#include <string>
#include <vector>

namespace innergs {

/// The value of a residual grid at continuous indices of it; 0 outside it. Between the voxels it is
/// interpolated by cubic convolution (Keys, IEEE Trans. ASSP 29, 1981, eq. 4 with a = kKeys).
float residualAt(const Volume& residual, const Vec3& index);

constexpr float kKeys = -0.75F;
constexpr double kIndexRounding = 1e-6; // of the maps between grids, in voxels: nearer to a voxel is on it

/// residualAt() along rows of points, for one instruction set.
struct ResidualKernels {
  std::string name;
  /// row[i] += residualAt(start + i·step), for i in [begin, end).
  void (*add)(const Volume& residual, const Vec3& start, const Vec3& step, int begin, int end, float* row);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<ResidualKernels>& residualKernelSets();

} // namespace innergs
