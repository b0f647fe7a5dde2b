#pragma once
#include "Core/Base/Random.h"
#include "Core/Image/Stack.h"

#include <algorithm>
#include <cmath>

namespace innergs::testing {

/// Balls of random values on a bright background, the same along all axes, with edges one voxel wide; cubic
/// voxels of 1 mm.
inline Volume spherePhantom(std::int64_t width, std::int64_t depth, std::uint64_t seed = 1) {
  Volume volume;
  volume.geometry.size = {width, width, depth};
  volume.voxels.assign(static_cast<std::size_t>(width * width * depth), 100.f);
  Random random(seed);
  const std::int64_t balls = width * width * depth / 1500;
  for (std::int64_t b = 0; b < balls; ++b) {
    const double radius = 2 + 6 * random.uniform() * random.uniform();
    const auto value = static_cast<float>(20 + 140 * random.uniform());
    double centre[3];
    std::int64_t from[3], to[3];
    for (int a = 0; a < 3; ++a) {
      const std::int64_t n = volume.geometry.size[a];
      centre[a] = static_cast<double>(n + 16) * random.uniform() - 8;
      from[a] = std::max<std::int64_t>(0, std::llround(centre[a] - radius) - 2);
      to[a] = std::min<std::int64_t>(n - 1, std::llround(centre[a] + radius) + 2);
    }
    for (std::int64_t k = from[2]; k <= to[2]; ++k)
      for (std::int64_t j = from[1]; j <= to[1]; ++j)
        for (std::int64_t i = from[0]; i <= to[0]; ++i) {
          const double r = std::hypot(static_cast<double>(i) - centre[0], static_cast<double>(j) - centre[1],
                                      static_cast<double>(k) - centre[2]);
          float& v = volume.voxels[static_cast<std::size_t>(i + width * (j + width * k))];
          v += static_cast<float>(std::clamp(radius - r + 0.5, 0.0, 1.0)) * (value - v);
        }
  }
  return volume;
}

} // namespace innergs::testing
