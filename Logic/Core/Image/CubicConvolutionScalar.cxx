#include "Core/Image/CubicConvolutionScalar.h"

#include <algorithm>

namespace innergs {
namespace {

/// Of the 4³ voxels from `first` on. Loops over four floats, which compilers turn into vectors.
float convolved(const float* first, std::int64_t line, std::int64_t plane, const float* fraction, float a) {
  float weights[4][4]; // of the voxels −1, 0, 1 and 2 along each axis; those of one axis sum to 1
  for (int axis = 0; axis < 4; ++axis) {
    const auto along = keysWeights(fraction[axis], a);
    for (int i = 0; i < 4; ++i)
      weights[i][axis] = along[i];
  }
  float columns[4] = {0, 0, 0, 0};
  for (int k = 0; k < 4; ++k) {
    float sheet[4] = {0, 0, 0, 0};
    for (int j = 0; j < 4; ++j) {
      const float* row = first + j * line + k * plane;
      for (int i = 0; i < 4; ++i)
        sheet[i] += weights[j][1] * row[i];
    }
    for (int i = 0; i < 4; ++i)
      columns[i] += weights[k][2] * sheet[i];
  }
  return weights[0][0] * columns[0] + weights[1][0] * columns[1] + weights[2][0] * columns[2] +
         weights[3][0] * columns[3];
}

void addRow(const Volume& volume, const Vec3& start, const Vec3& step, float a, int begin, int end,
            float* row) {
  for (int i = begin; i < end; ++i)
    row[i] += cubicAt(volume, start + static_cast<double>(i) * step, a);
}

} // namespace

float cubicAt(const Volume& volume, const Vec3& x, float keys) {
  const auto& n = volume.geometry.size;
  std::int64_t low[3];
  float fraction[4] = {0, 0, 0, 0};
  bool onVoxel = true, inner = true;
  for (int a = 0; a < 3; ++a) {
    const auto last = static_cast<double>(n[a] - 1);
    if (!(x[a] >= -0.5 - kIndexRounding && x[a] <= last + 0.5 + kIndexRounding)) return 0;
    const double at = std::clamp(x[a], 0.0, last);
    low[a] = static_cast<std::int64_t>(at + kIndexRounding);
    const double above = at - static_cast<double>(low[a]);
    onVoxel = onVoxel && above < kIndexRounding;
    inner = inner && low[a] >= 1 && low[a] + 2 < n[a];
    fraction[a] = static_cast<float>(std::max(0.0, above));
  }
  const std::int64_t line = n[0], plane = n[0] * n[1];
  const float* nearest = volume.voxels.data() + low[0] + line * low[1] + plane * low[2];
  if (onVoxel) return *nearest;
  if (inner) return convolved(nearest - 1 - line - plane, line, plane, fraction, keys);
  float block[64]; // the voxels around, edge voxels repeated
  for (int t = 0; t < 64; ++t) {
    const auto voxel = [&](int a, int step) {
      return std::clamp<std::int64_t>(low[a] + step - 1, 0, n[a] - 1);
    };
    block[t] = volume.voxels[voxel(0, t % 4) + line * voxel(1, t / 4 % 4) + plane * voxel(2, t / 16)];
  }
  return convolved(block, 4, 16, fraction, keys);
}

CubicConvolution scalarCubicConvolution() {
  return {"scalar", addRow};
}

} // namespace innergs
