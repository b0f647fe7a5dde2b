#pragma once
#include "Core/Image/Volume.h"

#include <string>
#include <vector>

namespace innergs {

/// Cubic convolution (Keys, IEEE Trans. ASSP 29, 1981, eq. 4 with a = kKeys) at a continuous index; beyond
/// the outermost voxel centres their values go on to the voxels' edges, and outside it is 0.
float cubicAt(const Volume& volume, const Vec3& index);

constexpr float kKeys = -0.75F;
constexpr double kIndexRounding = 1e-6; // of the maps between grids, in voxels: nearer to a voxel is on it

/// cubicAt() along rows of points, for one instruction set.
struct CubicConvolution {
  std::string name;
  /// row[i] += cubicAt(start + i·step), for i in [begin, end).
  void (*add)(const Volume& volume, const Vec3& start, const Vec3& step, int begin, int end, float* row);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<CubicConvolution>& cubicConvolutions();

} // namespace innergs
