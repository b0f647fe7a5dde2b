#pragma once
#include "Core/Fit/AdamStep.h"
#include "Core/Render/ChainRule.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Bin.h"

namespace innergs::cuda {

/// From the moments of one grid to the gradient of the 16 parameters; adds unless it is the first grid.
struct Chain {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Gaussian* gaussians;
  const math::Moments<float>* moments;
  std::int64_t count;
  ChainRules rules;
  float* gradient;
  bool first;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      Record sum = {};
      if (!first) sum = loaded(recordsAt(gradient) + i);
      addParameterGradient(loaded(gaussians + i), loaded(moments + i), rules, sum.v);
      stored(recordsAt(gradient) + i, sum);
    });
  }
};

/// Adam, the gradient sums of Densify.h, and the count of iterations.
struct Update {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const float* gradient;
  std::int64_t count;
  AdamStep step;
  Gaussian* gaussians;
  float *moment1, *moment2;
  float* gradientSums; // null: not needed
  float gradientUnit;
  IterationStatus* status;
  Guard guard;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      if (guard.closed()) return;
      if (i == 0) ++status->done;
      const Record g = loaded(recordsAt(gradient) + i);
      Record first = loaded(recordsAt(moment1) + i), second = loaded(recordsAt(moment2) + i);
      Gaussian gaussian = loaded(gaussians + i);
      if (gradientSums)
        gradientSums[i] += gradientUnit * std::sqrt(g.v[0] * g.v[0] + g.v[1] * g.v[1] + g.v[2] * g.v[2]);
      applyAdam(step, g.v, gaussian, first.v, second.v);
      stored(gaussians + i, gaussian);
      stored(recordsAt(moment1) + i, first);
      stored(recordsAt(moment2) + i, second);
    });
  }
};

} // namespace innergs::cuda
