#include "Core/Prediction/PlaneFusion.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Squared gradients along I and J of one slice, summed over 3×3 samples.
struct Energies {
  std::vector<float> i, j;
};

/// mean: of one slice.
Energies energiesOf(const std::vector<float>& mean, std::int64_t nx, std::int64_t ny) {
  const auto summed = [&](std::int64_t stepX, std::int64_t stepY) {
    std::vector<float> square(mean.size()), rows(mean.size()), sum(mean.size());
    for (std::int64_t y = 0; y < ny; ++y)
      for (std::int64_t x = 0; x < nx; ++x) {
        const auto at = [&](std::int64_t sign) {
          return mean[std::clamp<std::int64_t>(x + sign * stepX, 0, nx - 1) +
                      nx * std::clamp<std::int64_t>(y + sign * stepY, 0, ny - 1)];
        };
        const float change = at(1) - at(-1);
        square[x + nx * y] = change * change;
      }
    for (std::int64_t y = 0; y < ny; ++y)
      for (std::int64_t x = 0; x < nx; ++x) {
        const float* row = square.data() + nx * y;
        rows[x + nx * y] = row[std::max<std::int64_t>(x - 1, 0)] + row[x] + row[std::min(x + 1, nx - 1)];
      }
    for (std::int64_t y = 0; y < ny; ++y) {
      const float* above = rows.data() + nx * std::max<std::int64_t>(y - 1, 0);
      const float* below = rows.data() + nx * std::min(y + 1, ny - 1);
      for (std::int64_t x = 0; x < nx; ++x)
        sum[x + nx * y] = above[x] + rows[x + nx * y] + below[x];
    }
    return sum;
  };
  return {summed(1, 0), summed(0, 1)};
}

} // namespace

std::vector<float> fusedPlanes(const std::array<std::vector<float>, 2>& predicted,
                               const std::array<std::int64_t, 3>& n, ThreadPool& pool) {
  const std::int64_t area = n[0] * n[1];
  std::vector<float> fused(predicted[0].size());
  pool.blocks(n[2], 16, [&](std::int64_t from, std::int64_t to) {
    std::array<Energies, 3> near; // of slices k − 1, k and k + 1, at index k mod 3
    std::vector<float> mean(static_cast<std::size_t>(area));
    const auto add = [&](std::int64_t k) {
      const std::int64_t first = std::clamp<std::int64_t>(k, 0, n[2] - 1) * area;
      for (std::int64_t p = 0; p < area; ++p)
        mean[p] = 0.5f * (predicted[0][first + p] + predicted[1][first + p]);
      near[(k + 3) % 3] = energiesOf(mean, n[0], n[1]);
    };
    add(from - 1);
    add(from);
    for (std::int64_t k = from; k < to; ++k) {
      add(k + 1);
      for (std::int64_t p = 0; p < area; ++p) {
        const float i = std::sqrt(near[0].i[p] + near[1].i[p] + near[2].i[p]),
                    j = std::sqrt(near[0].j[p] + near[1].j[p] + near[2].j[p]);
        const std::int64_t v = k * area + p;
        fused[v] = predicted[1][v] + (i + j > 0 ? i / (i + j) : 0.5f) * (predicted[0][v] - predicted[1][v]);
      }
    }
  });
  return fused;
}

} // namespace innergs
