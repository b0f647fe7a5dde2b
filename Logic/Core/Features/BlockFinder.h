#pragma once
#include "Core/Image/GridGeometry.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace innergs {

/// Finds the block that contains a point, from the indices of a grid; −1 outside.
class BlockFinder {
public:
  BlockFinder(const GridGeometry& blocks, const Affine3& indexToWorld)
      : size_(blocks.size), map_(inverse(blocks.indexToWorld()) * indexToWorld) {}
  std::int64_t operator()(const Vec3& index) const {
    const Vec3 x = map_(index);
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      if (!(x[a] >= -0.5 && x[a] < static_cast<double>(size_[a]) - 0.5)) return -1;
      at[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x[a] + 0.5)), 0, size_[a] - 1);
    }
    return at[0] + size_[0] * (at[1] + size_[1] * at[2]);
  }

private:
  std::array<std::int64_t, 3> size_;
  Affine3 map_;
};

} // namespace innergs
