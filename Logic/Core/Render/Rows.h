#pragma once
#include "Core/Render/Projection.h"

#include <cmath>

namespace innergs {

struct GridView {
  int nx, ny, nz, stride;
  const double* z; // plane positions, index units
};

/// Rows [y0, y1) of planes [k0, k1): the part that one task owns while it accumulates.
struct TileRange {
  int y0, y1, k0, k1;
};

/// The first plane at or above `position`: guessed from even spacing, then corrected step by step.
INNERGS_HD inline int firstPlane(const GridView& grid, double position) {
  const double span = grid.z[grid.nz - 1] - grid.z[0];
  const double guess = span > 0 ? (position - grid.z[0]) * (grid.nz - 1) / span : 0.0;
  int k = guess > 0 ? static_cast<int>(math::least(guess, static_cast<double>(grid.nz))) : 0;
  while (k > 0 && grid.z[k - 1] >= position)
    --k;
  while (k < grid.nz && grid.z[k] < position)
    ++k;
  return k;
}

/// The planes that the selection covers: [first, last).
INNERGS_HD inline void planeRange(const Projected& g, const GridView& grid, int& first, int& last) {
  const double centre = g.cell[2] + static_cast<double>(g.fraction[2]);
  first = firstPlane(grid, centre - g.half[2]);
  last = first;
  while (last < grid.nz && grid.z[last] <= centre + g.half[2])
    ++last;
}

/// Distance of a plane to the mean, index units.
INNERGS_HD inline float planeOffset(const Projected& g, double z) {
  return static_cast<float>(z - g.cell[2] - static_cast<double>(g.fraction[2]));
}

/// The first index at or above x and the last one at or below, clamped to what an int can hold including the
/// sum with a cell; NaN counts as far below. Without std::ceil() and std::floor(), which may be calls.
INNERGS_HD inline int indexFrom(float x) {
  x = math::least(1e9f, math::most(-1e9f, x));
  const int whole = static_cast<int>(x);
  return whole + (x > static_cast<float>(whole) ? 1 : 0);
}
INNERGS_HD inline int indexUpTo(float x) {
  x = math::least(1e9f, math::most(-1e9f, x));
  const int whole = static_cast<int>(x);
  return whole - (x < static_cast<float>(whole) ? 1 : 0);
}

/// Half edge of Method2's square in a plane at distance dz: 3√λ_max·√p(t).
INNERGS_HD inline float squareHalf(const Projected& g, float dz) {
  return g.square * std::exp(-0.25f * dz * dz * g.precisionZ);
}

/// Columns that Method1 and Method2 evaluate in one plane, relative to cell[0]: centre ± half; Method2's rows
/// have the same half extent.
struct PlaneBox {
  float centre, half;
};
template <Selection selection>
INNERGS_HD inline PlaneBox planeBox(const Projected& g, float dz) {
  if constexpr (selection == Selection::Method1) return {g.fraction[0], g.half[0]};
  if constexpr (selection == Selection::Method2) return {g.fraction[0] + g.shiftXZ * dz, squareHalf(g, dz)};
  return {};
}

/// Rows that the selection covers in a plane at distance dz, relative to cell[1]: [first, last). Exact:
/// precisely those of the ellipsoid.
template <Selection selection>
INNERGS_HD inline bool rowRange(const Projected& g, float dz, const PlaneBox& box, int& first, int& last) {
  float half, centre = g.fraction[1];
  if constexpr (selection == Selection::Exact) {
    const float rest = g.radius2 - math::product(math::product(dz, dz), g.precisionZ);
    if (!(rest > 0)) return false;
    half = std::sqrt(rest / g.precisionY);
  } else {
    half = selection == Selection::Method1 ? g.half[1] : box.half;
  }
  if constexpr (selection != Selection::Method1) centre -= math::product(g.shiftYZ, dz);
  first = indexFrom(centre - half);
  last = indexUpTo(centre + half) + 1;
  return first < last;
}
INNERGS_HD inline bool rowRange(const Projected& g, float dz, int& first, int& last) {
  return rowRange<Selection::Exact>(g, dz, PlaneBox{}, first, last);
}

/// Columns that the selection can cover at all, relative to cell[0]: [first, last).
INNERGS_HD inline void columnRange(const Projected& g, int& first, int& last) {
  first = indexFrom(g.fraction[0] - g.half[0]);
  last = indexUpTo(g.fraction[0] + g.half[0]) + 1;
}

/// Columns of the cut-off ellipsoid's row at distances (dy, dz), relative to cell[0]: centre ± half.
INNERGS_HD inline void ellipsoidRow(const Projected& g, float dy, float dz, float& centre, float& half) {
  const float v = dy + g.shiftYZ * dz, slope = 0.5f / g.quadratic[0];
  const float rest = g.radius2 - dz * dz * g.precisionZ - v * v * g.precisionY;
  centre = g.fraction[0] - slope * (g.quadratic[1] * dy + g.quadratic[2] * dz);
  // Slightly wider than the ellipse, so that rounding does not lose a pixel on it. 1/Pxx = −slope / ln 2.
  half = math::roughSqrt(math::most(rest, 0.f) * (slope * -1.44269504088896340736f)) * 1.00001f + 1e-4f;
}

} // namespace innergs
