#pragma once
#include "Core/Image/Volume.h"

#include <array>
#include <string>
#include <vector>

namespace innergs {

/// Keys's parameter: −1/2, his optimum, is exact on parabolas; below it, edges are steeper.
constexpr float kKeys = -0.5F;
constexpr double kIndexRounding = 1e-6; // of the maps between grids, in voxels: nearer to a voxel is on it

/// Keys's weights of the voxels −1, 0, 1 and 2 at a fraction of the way from voxel 0 to 1. Their sum is 1.
template <class Real>
std::array<Real, 4> keysWeights(Real f, Real a) {
  const Real g = 1 - f;
  return {a * f * g * g, ((a + 2) * f - (a + 3)) * f * f + 1, ((a + 2) * g - (a + 3)) * g * g + 1,
          a * g * f * f};
}

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
