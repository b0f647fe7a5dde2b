#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"
#include "Core/Settings/Settings.h"

namespace innergs {

struct LossSum {
  double loss = 0;    // sum over samples
  double squared = 0; // Σ (rendered − target)², for the PSNR
  std::int64_t samples = 0;

  LossSum& operator+=(const LossSum& other) {
    loss += other.loss;
    squared += other.squared;
    samples += other.samples;
    return *this;
  }
};

struct LossKinds {
  LossKind kind = LossKind::L2;
  double huberDelta = 0.02;
  double ssimWeight = 0;
  double pointWeight = 1; // weight of the per-sample loss
};

/// Loss of every slice, with its gradient distributed to the sub-planes: `weights` and `numerators` become F0
/// and F1 (Docs/method.md; alpha blending: ∂L/∂I and I).
LossSum lossPass(const Observation& observation, const GaussianField& field, const LossKinds& kinds,
                 float* weights, float* numerators, ThreadPool& pool);

} // namespace innergs
