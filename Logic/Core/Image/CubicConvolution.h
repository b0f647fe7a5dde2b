#pragma once
#include "Core/Image/Volume.h"

#include <string>
#include <vector>

namespace innergs {

/// Keys's parameter: −1/2, his optimum, is exact on parabolas; below it, edges are steeper.
constexpr float kKeys = -0.5F;
constexpr double kIndexRounding = 1e-6; // of the maps between grids, in voxels: nearer to a voxel is on it

/// Cubic convolution (Keys, IEEE Trans. ASSP 29, 1981, eq. 4) at a continuous index. Edge voxels repeat, up
/// to their own outer edges; beyond those it is 0.
float cubicAt(const Volume& volume, const Vec3& index, float a = kKeys);

/// cubicAt() along rows of points, for one instruction set.
struct CubicConvolution {
  std::string name;
  /// row[i] += cubicAt(start + i·step), for i in [begin, end).
  void (*add)(const Volume& volume, const Vec3& start, const Vec3& step, float a, int begin, int end,
              float* row);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<CubicConvolution>& cubicConvolutions();

} // namespace innergs
