#pragma once
#include "Core/Model/GaussianMath.h"
#include "Core/Render/Projected.h"
#include "Core/Render/Rows.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace innergs {

/// The inner loops of all blendings, for one instruction set and candidate selection.
struct KernelSet {
  std::string name;
  Selection selection = Selection::Exact;
  /// weights += Σ w p′, numerators += Σ w p′ (c + g·d) over the tile, in the order of `ids`.
  void (*accumulate)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                     const GridView& grid, const TileRange& tile, float* weights, float* numerators);
  /// The moments of one Gaussian over its whole ellipsoid, in index coordinates. f0, f1: see Docs/method.md,
  /// zero in the row padding.
  void (*gather)(const Projected& gaussian, const GridView& grid, const float* f0, const float* f1,
                 math::Moments<float>& out);
  /// Alpha-blends one plane (tile.k1 = tile.k0 + 1) in the order of `ids`, front first: for each Gaussian I
  /// += T·a·c, T *= 1 − a. transmittance (T, starts at 1) and image (I) are laid out like `weights`.
  void (*composite)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                    const GridView& grid, const TileRange& tile, float* transmittance, float* image);
  /// The gradient of composite() for r = ∂L/∂I. transmittance (1) and rest (I) cover only the tile, [row −
  /// tile.y0][stride], and are overwritten. out: one per id.
  void (*compositeBackward)(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                            const GridView& grid, const TileRange& tile, const float* r, float* transmittance,
                            float* rest, math::PlaneMoments<float>* out);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<KernelSet>& kernelSets(Selection selection = Selection::Exact);
/// Empty name: the best. Throws Error(InvalidArgument) for a name that this processor does not support.
const KernelSet& kernelSet(const std::string& name, Selection selection = Selection::Exact);

} // namespace innergs
