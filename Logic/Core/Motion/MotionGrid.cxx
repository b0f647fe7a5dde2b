#include "Core/Motion/MotionGrid.h"

#include <algorithm>
#include <cmath>

namespace innergs {

MotionGrid::Place MotionGrid::place(const float* point) const {
  Place p;
  std::int64_t cell[3];
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp((static_cast<double>(point[a]) - origin[a]) / spacing[a], 0.0,
                                static_cast<double>(size[a] - 1));
    cell[a] = std::min(static_cast<std::int64_t>(x), size[a] - 2);
    p.fraction[a] = static_cast<float>(x - static_cast<double>(cell[a]));
  }
  p.node = static_cast<std::uint32_t>(cell[0] + size[0] * (cell[1] + size[1] * cell[2]));
  return p;
}

MotionGrid::Corners MotionGrid::corners(const Place& p) const {
  Corners c;
  const auto row = static_cast<std::uint32_t>(size[0]), plane = static_cast<std::uint32_t>(size[0] * size[1]);
  for (std::uint32_t n = 0; n < 8; ++n) {
    const bool x = n & 1, y = n & 2, z = n & 4;
    c.node[n] = p.node + (x ? 1u : 0u) + (y ? row : 0u) + (z ? plane : 0u);
    c.weight[n] = (x ? p.fraction[0] : 1 - p.fraction[0]) * (y ? p.fraction[1] : 1 - p.fraction[1]) *
                  (z ? p.fraction[2] : 1 - p.fraction[2]);
  }
  return c;
}

std::array<float, MotionGrid::kValues> MotionGrid::at(const Place& p, std::span<const float> values) const {
  const Corners c = corners(p);
  std::array<float, kValues> sum{};
  for (int n = 0; n < 8; ++n)
    for (int v = 0; v < kValues; ++v)
      sum[v] += c.weight[n] * values[static_cast<std::size_t>(c.node[n]) * kValues + v];
  return sum;
}

MotionGrid motionGridOver(const Vec3& low, const Vec3& high, const Vec3& spacing) {
  MotionGrid grid;
  grid.origin = low;
  for (int a = 0; a < 3; ++a) {
    const double extent = high[a] - low[a];
    grid.size[a] = std::max<std::int64_t>(2, std::llround(extent / spacing[a]) + 1);
    grid.spacing[a] = std::max(extent, 1e-6) / static_cast<double>(grid.size[a] - 1);
  }
  return grid;
}

double addBending(const MotionGrid& grid, std::span<const float> values, double rotationScale, double weight,
                  std::span<float> gradient) {
  constexpr int n = MotionGrid::kValues;
  const std::int64_t step[3] = {1, grid.size[0], grid.size[0] * grid.size[1]};
  double sum = 0;
  for (std::int64_t k = 0; k < grid.size[2]; ++k)
    for (std::int64_t j = 0; j < grid.size[1]; ++j)
      for (std::int64_t i = 0; i < grid.size[0]; ++i) {
        const std::int64_t at[3] = {i, j, k}, node = i + j * step[1] + k * step[2];
        for (int a = 0; a < 3; ++a) {
          if (at[a] == 0 || at[a] + 1 == grid.size[a]) continue;
          const std::int64_t before = n * (node - step[a]), here = n * node, after = n * (node + step[a]);
          for (int v = 0; v < n; ++v) {
            const double scale = v < 3 ? 1 : rotationScale * rotationScale;
            const auto d = static_cast<double>(values[before + v] - 2 * values[here + v] + values[after + v]);
            sum += scale * d * d;
            const auto g = static_cast<float>(2 * weight * scale * d);
            gradient[before + v] += g;
            gradient[here + v] -= 2 * g;
            gradient[after + v] += g;
          }
        }
      }
  return weight * sum;
}

} // namespace innergs
