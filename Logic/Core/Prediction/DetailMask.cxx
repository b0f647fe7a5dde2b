#include "Core/Prediction/DetailMask.h"

#include <algorithm>
#include <cmath>

namespace innergs {

void dilate(std::vector<std::uint8_t>& mask, const std::array<std::int64_t, 3>& n,
            const std::array<std::int64_t, 3>& reach, ThreadPool& pool) {
  const std::int64_t steps[3] = {1, n[0], n[0] * n[1]};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::uint8_t> before = mask;
    pool.blocks(n[1] * n[2], 64, [&](std::int64_t from, std::int64_t to) {
      for (std::int64_t row = from; row < to; ++row) {
        const std::int64_t at[3] = {0, row % n[1], row / n[1]};
        for (std::int64_t i = 0; i < n[0]; ++i) {
          const std::int64_t along = axis == 0 ? i : at[axis], v = row * n[0] + i;
          const std::int64_t least = std::max(-reach[axis], -along),
                             most = std::min(reach[axis], n[axis] - 1 - along);
          for (std::int64_t d = least; d <= most && !mask[v]; ++d)
            mask[v] = before[v + d * steps[axis]];
        }
      }
    });
  }
}

std::vector<std::uint8_t> detailMask(const FilledImage& filled, std::vector<std::uint8_t> body, double noise,
                                     ThreadPool& pool) {
  constexpr double unlikely = 5; // difference of two neighbours, in units of the noise
  const auto& n = filled.image.geometry.size;
  const std::int64_t steps[3] = {1, n[0], n[0] * n[1]};
  const auto least = static_cast<float>(unlikely * noise);
  const float* image = filled.image.voxels.data();
  pool.blocks(n[1] * n[2], 64, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t row = from; row < to; ++row) {
      const std::int64_t at[3] = {0, row % n[1], row / n[1]};
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const std::int64_t v = row * n[0] + i;
        for (int axis = 0; axis < 3 && !body[v]; ++axis) {
          const std::int64_t along = axis == 0 ? i : at[axis];
          body[v] = (along > 0 && std::abs(image[v] - image[v - steps[axis]]) > least) ||
                    (along + 1 < n[axis] && std::abs(image[v] - image[v + steps[axis]]) > least);
        }
      }
    }
  });
  dilate(body, n, {2, 2, 1}, pool);
  return body;
}

} // namespace innergs
