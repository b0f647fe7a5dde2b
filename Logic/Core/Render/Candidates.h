#pragma once
#include "Core/Render/Kernels.h"

namespace innergs {

/// Visits exactly what a selection evaluates of one Gaussian on a tile, row by row: visit(plane k, row y,
/// first column x0, end of columns x1).
template <Selection selection, class Visit>
void forEachCandidateRow(const Projected& g, const GridView& grid, const TileRange& tile, Visit&& visit) {
  int k0, k1;
  planeRange(g, grid, k0, k1);
  const auto clamped = [](std::int64_t cell, int x, int low, int high) {
    return static_cast<int>(std::clamp<std::int64_t>(cell + x, low, high));
  };
  for (int k = std::max(k0, tile.k0); k < std::min(k1, tile.k1); ++k) {
    const float dz = planeOffset(g, grid.z[k]);
    PlaneBox box = planeBox<selection>(g, dz);
    int r0, r1;
    if (!rowRange<selection>(g, dz, box, r0, r1)) continue;
    const int y0 = clamped(g.cell[1], r0, tile.y0, tile.y1), y1 = clamped(g.cell[1], r1, tile.y0, tile.y1);
    for (int y = y0; y < y1; ++y) {
      if constexpr (selection == Selection::Exact)
        ellipsoidRow(g, static_cast<float>(y - g.cell[1]) - g.fraction[1], dz, box.centre, box.half);
      const int x0 = clamped(g.cell[0], indexFrom(box.centre - box.half), 0, grid.nx);
      const int x1 = clamped(g.cell[0], indexUpTo(box.centre + box.half) + 1, 0, grid.nx);
      if (x0 < x1) visit(k, y, x0, x1);
    }
  }
}

template <class Visit>
void forEachCandidateRow(const Projected& g, const GridView& grid, Selection selection, const TileRange& tile,
                         Visit&& visit) {
  switch (selection) {
  case Selection::Exact:
    return forEachCandidateRow<Selection::Exact>(g, grid, tile, visit);
  case Selection::Method1:
    return forEachCandidateRow<Selection::Method1>(g, grid, tile, visit);
  case Selection::Method2:
    return forEachCandidateRow<Selection::Method2>(g, grid, tile, visit);
  }
}

} // namespace innergs
