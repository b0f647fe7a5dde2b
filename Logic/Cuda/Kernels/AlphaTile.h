#pragma once
#include "Cuda/Block.h"
#include "Cuda/Kernels/Reach.h"

namespace innergs::cuda {

/// Shared by both passes of alpha blending: a block owns a 16×16 tile of one plane, a thread one point, a
/// warp 8×4 points.
struct AlphaTile {
  static constexpr int kThreads = 256, kEdge = TileReach::kEdge;

  /// A Gaussian on the tile's plane.
  struct alignas(16) Staged {
    float cell[2]; // relative to the tile's first point
    float fraction[2];
    float xx, xy, yy, x, y, constant; // of the exponent
    float log2Cut, cut, value, halfX;
    float rowCentre, rowHalf; // rows that it covers, relative to cell[1]
  };

  TileReach tiles;
  const Projected* gaussians;
  const std::int64_t* start;
  const std::uint32_t* slots;  // sorted by tile and depth
  const std::uint32_t* owners; // of the slots

  INNERGS_HD int plane(int tile) const { return tile / tiles.nx / tiles.ny; }
  INNERGS_HD int left(int tile) const { return tile % tiles.nx * kEdge; }
  INNERGS_HD int top(int tile) const { return tile / tiles.nx % tiles.ny * kEdge; }
  INNERGS_HD static int warpX(int t) { return t / kWarp % 2 * 8; }
  INNERGS_HD static int warpY(int t) { return t / kWarp / 2 * 4; }
  INNERGS_HD static int pointX(int t) { return warpX(t) + t % 8; }
  INNERGS_HD static int pointY(int t) { return warpY(t) + t % kWarp / 8; }

  INNERGS_HD void stage(std::int64_t at, int left, int top, double z, Staged& s) const {
    const Projected g = loaded(gaussians + owners[slots[at]]);
    const int low[2] = {left, top};
    const float dz = planeOffset(g, z), *q = g.quadratic;
    for (int a = 0; a < 2; ++a) {
      s.cell[a] = static_cast<float>(g.cell[a] - low[a]);
      s.fraction[a] = g.fraction[a];
    }
    s.xx = q[0];
    s.xy = q[1];
    s.yy = q[3];
    s.x = q[2] * dz;
    s.y = q[4] * dz;
    s.constant = q[5] * dz * dz + g.log2Weight;
    s.log2Cut = g.log2Cut;
    s.cut = g.cut;
    s.value = g.value;
    s.halfX = g.half[0];
    s.rowCentre = g.fraction[1] - g.shiftYZ * dz;
    s.rowHalf = std::sqrt(math::most(0.f, g.radius2 - dz * dz * g.precisionZ) / g.precisionY);
  }

  /// Whether the Gaussian may reach the points of thread t's warp.
  INNERGS_HD static bool meets(const Staged& s, int t) {
    const float x = s.cell[0] - static_cast<float>(warpX(t)) + s.fraction[0];
    const float y = s.cell[1] - static_cast<float>(warpY(t)) + s.rowCentre;
    return x + s.halfX >= 0 && x - s.halfX <= 7 && y + s.rowHalf >= 0 && y - s.rowHalf <= 3;
  }

  /// α p before the cut at a point of the tile, 0 beyond the cut-off.
  INNERGS_HD static float amplitude(const Staged& s, float x, float y, float& dx, float& dy) {
    dx = x - s.cell[0] - s.fraction[0];
    dy = y - s.cell[1] - s.fraction[1];
    const float e = dx * (s.xx * dx + s.xy * dy + s.x) + dy * (s.yy * dy + s.y) + s.constant;
    return e >= s.log2Cut ? math::exp2Normal(e) : 0.f; // 0 for NaN too
  }
};

} // namespace innergs::cuda
