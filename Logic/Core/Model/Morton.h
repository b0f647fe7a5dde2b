#pragma once
#include "Core/Model/Gaussian.h"
#include "Core/Model/GaussianMath.h"

namespace innergs {

/// Moves the 21 lowest bits of x to every third bit of the result.
INNERGS_HD inline std::uint64_t spreadBits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffffull;
  x = (x | x << 16) & 0x1f0000ff0000ffull;
  x = (x | x << 8) & 0x100f00f00f00f00full;
  x = (x | x << 4) & 0x10c30c30c30c30c3ull;
  return (x | x << 2) & 0x1249249249249249ull;
}

/// The place of a cell along the Z-order curve (Morton 1966).
INNERGS_HD inline std::uint64_t morton(std::uint64_t i, std::uint64_t j, std::uint64_t k) {
  return spreadBits(i) | spreadBits(j) << 1 | spreadBits(k) << 2;
}

/// The bounding box of the means (mm); starts empty.
struct MeanBox {
  float low[3], high[3];

  INNERGS_HD static MeanBox empty() { return {{1e30f, 1e30f, 1e30f}, {-1e30f, -1e30f, -1e30f}}; }
  INNERGS_HD void add(const float* lowest, const float* highest) {
    for (int a = 0; a < 3; ++a) {
      low[a] = math::least(low[a], lowest[a]);
      high[a] = math::most(high[a], highest[a]);
    }
  }
};

constexpr int kMortonBits = 30; // of mortonCode()

/// The position along a Morton curve, on a grid of 1024³ over the cube around the box.
INNERGS_HD inline std::uint64_t mortonCode(const Gaussian& g, const MeanBox& box) {
  float extent = 1e-6f;
  for (int a = 0; a < 3; ++a)
    extent = math::most(extent, box.high[a] - box.low[a]);
  std::uint64_t c[3];
  for (int a = 0; a < 3; ++a)
    c[a] = static_cast<std::uint64_t>((g.mean[a] - box.low[a]) / extent * 1023.f);
  return morton(c[0], c[1], c[2]);
}

} // namespace innergs
