#pragma once
#include "Core/Render/Rows.h"

#include <cstring>

namespace innergs::cuda {

/// Range [first, last) of the `cells` cells, each `edge` index units wide, that [centre − half, centre +
/// half] touches; empty for NaN.
INNERGS_HD inline void cellRange(double centre, double half, int edge, int cells, int& first, int& last) {
  first = last = 0;
  const double low = std::ceil(centre - half) / edge, high = std::floor(centre + half) / edge;
  if (!(high >= 0) || !(low < cells) || !(low <= high)) return;
  first = low > 0 ? static_cast<int>(low) : 0;
  last = high < cells - 1 ? static_cast<int>(high) + 1 : cells;
}

INNERGS_HD inline double centreOf(const Projected& g, int axis) {
  return g.cell[axis] + static_cast<double>(g.fraction[axis]);
}

/// Bricks of a grid, 16×8×4 points: one block of Accumulate owns one.
struct BrickReach {
  static constexpr int kX = 16, kY = 8, kZ = 4;
  GridView grid;
  int nx, ny, nz; // bricks

  INNERGS_HD std::int64_t count() const { return static_cast<std::int64_t>(nx) * ny * nz; }

  /// visit(key) for every brick that a Gaussian's box touches.
  template <class Visit>
  INNERGS_HD void visit(const Projected& g, Visit&& visit) const {
    int k0, k1, x0, x1, y0, y1;
    planeRange(g, grid, k0, k1);
    if (k0 >= k1) return;
    cellRange(centreOf(g, 0), g.half[0], kX, nx, x0, x1);
    cellRange(centreOf(g, 1), g.half[1], kY, ny, y0, y1);
    for (int z = k0 / kZ; z <= (k1 - 1) / kZ; ++z)
      for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
          visit((static_cast<std::uint64_t>(z) * ny + y) * nx + x);
  }
};

/// Tiles of single planes, 16×16 points: one block of Composite owns one. Keys sort by tile, then by the
/// distance of the centre to the plane.
struct TileReach {
  static constexpr int kEdge = 16;
  GridView grid;
  int nx, ny; // tiles per plane

  INNERGS_HD std::int64_t count() const { return static_cast<std::int64_t>(nx) * ny * grid.nz; }

  /// visit(key, distance of the plane)
  template <class Visit>
  INNERGS_HD void visit(const Projected& g, Visit&& visit) const {
    int k0, k1, x0, x1;
    planeRange(g, grid, k0, k1);
    cellRange(centreOf(g, 0), g.half[0], kEdge, nx, x0, x1);
    for (int k = k0; k < k1 && x0 < x1; ++k) {
      const float dz = planeOffset(g, grid.z[k]);
      int r0, r1;
      if (!rowRange(g, dz, r0, r1)) continue;
      const std::int64_t low = math::most<std::int64_t>(0, static_cast<std::int64_t>(g.cell[1]) + r0);
      const std::int64_t high =
          math::least<std::int64_t>(grid.ny, static_cast<std::int64_t>(g.cell[1]) + r1) - 1;
      if (low > high) continue;
      const float depth = std::fabs(dz);
      std::uint32_t bits; // floats ≥ 0 sort like their bits
      std::memcpy(&bits, &depth, sizeof bits);
      for (int y = static_cast<int>(low) / kEdge; y <= static_cast<int>(high) / kEdge; ++y)
        for (int x = x0; x < x1; ++x)
          visit((((static_cast<std::uint64_t>(k) * ny + y) * nx + x) << 32) | bits, dz);
    }
  }
};

/// Cells of 1 index unit, for point queries.
struct CellReach {
  int nx, ny, nz;

  INNERGS_HD std::int64_t count() const { return static_cast<std::int64_t>(nx) * ny * nz; }

  template <class Visit>
  INNERGS_HD void visit(const Projected& g, Visit&& visit) const {
    int low[3], high[3];
    const int cells[3] = {nx, ny, nz};
    for (int a = 0; a < 3; ++a) {
      const double first = std::floor(centreOf(g, a) - g.half[a]),
                   last = std::floor(centreOf(g, a) + g.half[a]);
      if (!(last >= 0) || !(first < cells[a])) return;
      low[a] = first > 0 ? static_cast<int>(first) : 0;
      high[a] = last < cells[a] ? static_cast<int>(last) : cells[a] - 1;
    }
    for (int z = low[2]; z <= high[2]; ++z)
      for (int y = low[1]; y <= high[1]; ++y)
        for (int x = low[0]; x <= high[0]; ++x)
          visit((static_cast<std::uint64_t>(z) * ny + y) * nx + x);
  }
};

} // namespace innergs::cuda
