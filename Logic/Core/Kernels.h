#pragma once
#include "Core/GaussianMath.h"
#include "Core/Projected.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace innergs {

struct LatticeView {
  int nx, ny, nz, stride;
  const double* z; // plane positions, index units
};

/// Rows [y0, y1) of planes [k0, k1): what one task owns while it accumulates.
struct TileRange {
  int y0, y1, k0, k1;
};

/// The inner loops of every blending, for one instruction set and candidate selection.
struct KernelSet {
  std::string name;
  Selection selection = Selection::Exact;
  /// weights += Σ w p′, numerators += Σ w p′ (c + g·d) over the tile, in the order of `ids`.
  void (*accumulate)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                     const LatticeView& lattice, const TileRange& tile, float* weights, float* numerators);
  /// The moments of one Gaussian over its whole ellipsoid, index coordinates. f0, f1: Docs/method.md, zero in
  /// the row padding.
  void (*gather)(const Projected& gaussian, const LatticeView& lattice, const float* f0, const float* f1,
                 math::Moments<float>& out);
  /// Alpha blending of one plane (tile.k1 = tile.k0 + 1) in the order of `ids`, front first: per Gaussian
  /// I += T·a·c, T *= 1 − a. transmittance (T, 1 at the start) and image (I) as `weights` above.
  void (*composite)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                    const LatticeView& lattice, const TileRange& tile, float* transmittance, float* image);
  /// Its gradient for r = ∂L/∂I. transmittance (1) and rest (I) hold the tile alone, [row − tile.y0][stride],
  /// and are used up. out: one per id.
  void (*compositeBackward)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                            const LatticeView& lattice, const TileRange& tile, const float* r,
                            float* transmittance, float* rest, math::PlaneMoments<float>* out);
};

/// Best first; the last is "scalar", the plain reference that all others are tested against.
const std::vector<KernelSet>& kernelSets(Selection selection = Selection::Exact);
/// Empty name: the best. Throws Error(InvalidArgument) for a name this processor does not have.
const KernelSet& kernelSet(const std::string& name, Selection selection = Selection::Exact);

/// The first plane at or above `position`: guessed from an even spacing, then stepped to the exact one.
inline int firstPlane(const LatticeView& lattice, double position) {
  const double span = lattice.z[lattice.nz - 1] - lattice.z[0];
  const double guess = span > 0 ? (position - lattice.z[0]) * (lattice.nz - 1) / span : 0.0;
  int k = guess > 0 ? static_cast<int>(std::min(guess, static_cast<double>(lattice.nz))) : 0;
  while (k > 0 && lattice.z[k - 1] >= position)
    --k;
  while (k < lattice.nz && lattice.z[k] < position)
    ++k;
  return k;
}

/// Planes that the selection reaches: [first, last).
inline void planeRange(const Projected& g, const LatticeView& lattice, int& first, int& last) {
  const double centre = g.cell[2] + static_cast<double>(g.fraction[2]);
  first = firstPlane(lattice, centre - g.half[2]);
  last = first;
  while (last < lattice.nz && lattice.z[last] <= centre + g.half[2])
    ++last;
}

/// Distance of a plane to the mean, index units.
inline float planeOffset(const Projected& g, double z) {
  return static_cast<float>(z - g.cell[2] - static_cast<double>(g.fraction[2]));
}

/// Within what an int and the sum with a cell can hold; NaN counts as far below.
inline int indexLimit(float x) {
  return static_cast<int>(std::min(1e9f, std::max(-1e9f, x)));
}

/// Pxx of the precision matrix.
inline float precisionX(const Projected& g) {
  return g.quadratic[0] * -1.38629436111989061883f; // −2·ln 2
}

/// Half edge of Method2's square in a plane at distance dz: 3√λ_max·√p(t).
inline float squareHalf(const Projected& g, float dz) {
  return g.square * std::exp(-0.25f * dz * dz * g.precisionZ);
}

/// Rows that the selection reaches in a plane at distance dz, relative to cell[1]: [first, last). Exact: no
/// more and no fewer than the ellipsoid's.
template <Selection selection = Selection::Exact>
inline bool rowRange(const Projected& g, float dz, int& first, int& last) {
  float half, centre = g.fraction[1];
  if constexpr (selection == Selection::Exact) {
    const float rest = g.radius2 - dz * dz * g.precisionZ;
    if (!(rest > 0)) return false;
    half = std::sqrt(rest / g.precisionY);
  } else {
    half = selection == Selection::Method1 ? g.half[1] : squareHalf(g, dz);
  }
  if constexpr (selection != Selection::Method1) centre -= g.shiftYZ * dz;
  first = indexLimit(std::ceil(centre - half));
  last = indexLimit(std::floor(centre + half)) + 1;
  return first < last;
}

/// Columns that the selection can reach at all, relative to cell[0]: [first, last).
inline void columnRange(const Projected& g, int& first, int& last) {
  first = indexLimit(std::ceil(g.fraction[0] - g.half[0]));
  last = indexLimit(std::floor(g.fraction[0] + g.half[0])) + 1;
}

} // namespace innergs
