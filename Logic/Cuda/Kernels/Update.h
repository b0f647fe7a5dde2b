#pragma once
#include "Core/AdamStep.h"
#include "Core/ChainRule.h"
#include "Cuda/Block.h"
#include "Cuda/Kernels/Bin.h"

namespace innergs::cuda {

/// Moments of one lattice to the gradient of the 16 parameters, added unless it is the first lattice.
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
      float sum[16];
      for (int c = 0; c < 16; ++c)
        sum[c] = first ? 0.f : gradient[16 * i + c];
      addParameterGradient(gaussians[i], moments[i], rules, sum);
      for (int c = 0; c < 16; ++c)
        gradient[16 * i + c] = sum[c];
    });
  }
};

/// Adam and the pulls of Densify.h, and a sweep more is done.
struct Update {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const float* gradient;
  std::int64_t count;
  AdamStep step;
  Gaussian* gaussians;
  float *moment1, *moment2;
  float* pulls; // null: not asked for
  float pullUnit;
  SweepStatus* status;
  Guard guard;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      if (guard.closed()) return;
      if (i == 0) ++status->done;
      const float* g = gradient + 16 * i;
      if (pulls) pulls[i] += pullUnit * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
      applyAdam(step, g, gaussians[i], moment1 + 16 * i, moment2 + 16 * i);
    });
  }
};

} // namespace innergs::cuda
