#pragma once
#include "Core/Kernels.h"

namespace innergs {

/// KernelSet "scalar": one voxel after the other, the oracle of all fast paths.
void accumulateScalar(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                      const LatticeView& lattice, const TileRange& tile, float* weights, float* numerators);
void gatherScalar(const Projected& gaussian, const LatticeView& lattice, const float* f0, const float* f1,
                  math::Moments<float>& out);

} // namespace innergs
