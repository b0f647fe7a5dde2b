#pragma once
#include "Core/Render/Projection.h"
#include "Cuda/Block.h"

namespace innergs::cuda {

/// Projects Gaussians to a grid's index coordinates. `values`: replaces intensity and slope if not null.
struct Project {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Gaussian* gaussians;
  const float* values;
  std::int64_t count;
  ProjectionFrame frame;
  ProjectionRules rules;
  Projected* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      Projected projected;
      projectGaussian(loaded(gaussians + i), values ? values + i : nullptr, frame, rules, projected);
      stored(out + i, projected);
    });
  }
};

} // namespace innergs::cuda
