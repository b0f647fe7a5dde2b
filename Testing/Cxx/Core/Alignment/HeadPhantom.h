#pragma once
#include "../Prediction/SpherePhantom.h"

namespace innergs::testing {

/// Balls in a ball `width` voxels across, in air.
inline Volume headPhantom(std::int64_t width, std::uint64_t seed = 5) {
  Volume volume = spherePhantom(width, width, seed);
  const double middle = 0.5 * static_cast<double>(width);
  for (std::int64_t k = 0; k < width; ++k)
    for (std::int64_t j = 0; j < width; ++j)
      for (std::int64_t i = 0; i < width; ++i)
        if (std::hypot(static_cast<double>(i) - middle, static_cast<double>(j) - middle,
                       static_cast<double>(k) - middle) > 0.8 * middle)
          volume.voxels[static_cast<std::size_t>(i + width * (j + width * k))] = 0;
  return volume;
}

} // namespace innergs::testing
