#pragma once
#include "Core/Model/GaussianField.h"

#include <algorithm>
#include <cmath>

namespace innergs {

/// A field's residual grid at continuous indices of a lattice; 0 outside it. Between the voxels it is
/// interpolated by cubic convolution (Keys, IEEE Trans. ASSP 29, 1981, eq. 4 with a = −3/4).
class ResidualSampler {
public:
  ResidualSampler(const GaussianField& field, const Affine3& indexToWorld) : residual_(field.residual) {
    if (!residual_.voxels.empty()) map_ = inverse(residual_.geometry.indexToWorld()) * indexToWorld;
  }

  float operator()(const Vec3& index) const {
    if (residual_.voxels.empty()) return 0;
    constexpr double kRounding = 1e-6; // of the index maps
    const auto& n = residual_.geometry.size;
    const Vec3 x = map_(index);
    std::int64_t low[3];
    float weights[3][4];
    bool onVoxel = true, inner = true;
    for (int a = 0; a < 3; ++a) {
      if (!(x[a] >= -0.5 - kRounding && x[a] <= static_cast<double>(n[a]) - 0.5 + kRounding)) return 0;
      const double at = std::clamp(x[a], 0.0, static_cast<double>(n[a] - 1));
      low[a] = static_cast<std::int64_t>(at + kRounding);
      const double fraction = std::max(0.0, at - static_cast<double>(low[a]));
      onVoxel = onVoxel && fraction < kRounding;
      inner = inner && low[a] >= 1 && low[a] + 2 < n[a];
      setWeights(static_cast<float>(fraction), weights[a]);
    }
    const std::int64_t line = n[0], plane = n[0] * n[1];
    const float* voxels = residual_.voxels.data();
    if (onVoxel) return voxels[low[0] + line * low[1] + plane * low[2]];
    std::int64_t offset[3][4];
    for (int a = 0; a < 3; ++a)
      for (int t = 0; t < 4; ++t)
        offset[a][t] = std::clamp<std::int64_t>(low[a] + t - 1, 0, n[a] - 1);
    float sums[4] = {0, 0, 0, 0}; // of the columns
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 4; ++j) {
        const float* row = voxels + line * offset[1][j] + plane * offset[2][k];
        const float weight = weights[1][j] * weights[2][k];
        if (inner)
          for (int i = 0; i < 4; ++i)
            sums[i] += weight * row[low[0] - 1 + i];
        else
          for (int i = 0; i < 4; ++i)
            sums[i] += weight * row[offset[0][i]];
      }
    return weights[0][0] * sums[0] + weights[0][1] * sums[1] + weights[0][2] * sums[2] +
           weights[0][3] * sums[3];
  }

private:
  /// Of the voxels −1, 0, 1 and 2 at a fraction between 0 and 1; they sum to 1.
  static void setWeights(float f, float* weights) {
    constexpr float a = -0.75F;
    const auto near = [](float d) { return ((a + 2) * d - (a + 3)) * d * d + 1; };      // d ≤ 1
    const auto far = [](float d) { return ((a * d - 5 * a) * d + 8 * a) * d - 4 * a; }; // 1 ≤ d ≤ 2
    weights[0] = far(1 + f);
    weights[1] = near(f);
    weights[2] = near(1 - f);
    weights[3] = far(2 - f);
  }

  const Volume& residual_;
  Affine3 map_;
};

} // namespace innergs
