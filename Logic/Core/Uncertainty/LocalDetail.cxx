#include "Core/Uncertainty/LocalDetail.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Each line along an axis becomes its running mean over ± reach voxels.
void average(std::vector<float>& values, const std::array<std::int64_t, 3>& size, int axis,
             std::int64_t reach, ThreadPool& pool) {
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? size[0] : size[0] * size[1];
  const std::int64_t n = size[axis], lines = size[0] * size[1] * size[2] / std::max<std::int64_t>(1, n);
  if (n < 2 || reach < 1) return;
  pool.blocks(lines, 256, [&](std::int64_t from, std::int64_t to) {
    std::vector<double> sum(static_cast<std::size_t>(n) + 1);
    for (std::int64_t line = from; line < to; ++line) {
      float* first = values.data() + line % stride + line / stride * stride * n;
      for (std::int64_t i = 0; i < n; ++i)
        sum[i + 1] = sum[i] + first[i * stride];
      for (std::int64_t i = 0; i < n; ++i) {
        const std::int64_t low = std::max<std::int64_t>(0, i - reach), high = std::min(n, i + reach + 1);
        first[i * stride] = static_cast<float>((sum[high] - sum[low]) / static_cast<double>(high - low));
      }
    }
  });
}

} // namespace

Volume localDetail(const Volume& volume, double radius, ThreadPool& pool) {
  const auto& n = volume.geometry.size;
  const std::int64_t stride[3] = {1, n[0], n[0] * n[1]};
  Volume detail{volume.geometry, std::vector<float>(volume.voxels.size())};
  pool.run(n[2], [&](std::int64_t k) {
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const std::int64_t v = i + n[0] * (j + n[1] * k), at[3] = {i, j, k};
        double squared = 0;
        for (int a = 0; a < 3; ++a) {
          const std::int64_t low = at[a] > 0 ? v - stride[a] : v, high = at[a] + 1 < n[a] ? v + stride[a] : v;
          if (low == high) continue;
          const double slope = (static_cast<double>(volume.voxels[high]) - volume.voxels[low]) /
                               (static_cast<double>((high - low) / stride[a]) * volume.geometry.spacing[a]);
          if (std::isfinite(slope)) squared += slope * slope;
        }
        detail.voxels[v] = static_cast<float>(squared);
      }
  });
  for (int pass = 0; pass < 2; ++pass)
    for (int a = 0; a < 3; ++a)
      average(detail.voxels, n, a, std::llround(0.5 * radius / volume.geometry.spacing[a]), pool);
  for (float& value : detail.voxels)
    value = std::sqrt(std::max(0.f, value));
  return detail;
}

Vec3 middleOf(const Volume& detail) {
  const auto& n = detail.geometry.size;
  Vec3 sum{};
  double weights = 0;
  for (std::int64_t v = 0; v < detail.geometry.voxelCount(); ++v) {
    const double w = detail.voxels[static_cast<std::size_t>(v)];
    sum = sum + w * Vec3{static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
                         static_cast<double>(v / (n[0] * n[1]))};
    weights += w;
  }
  return weights > 0 ? detail.geometry.indexToWorld()((1 / weights) * sum) : detail.geometry.centre();
}

} // namespace innergs
