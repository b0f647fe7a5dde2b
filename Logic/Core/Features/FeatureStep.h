#pragma once
#include "Core/Model/GaussianMath.h"

#include <cmath>
#include <cstdint>

/// What an iteration of trainFeatures() computes, on the CPU and on a device.
namespace innergs {

/// A Gaussian's share of the feature of a voxel, or a voxel's of a Gaussian.
struct FeatureEntry {
  std::uint32_t index;
  float weight; // w p / (Σ w p + ε)
};

/// The numbers of one iteration: Adam (Kingma & Ba 2015) without weight decay.
struct FeatureStep {
  static constexpr float kMomentum = 0.9f, kScaling = 0.99f; // decay of the moments
  float rate = 0, codeRate = 0;                              // of latents and of codes
  float correction1 = 1, correction2 = 1;                    // of the moments' bias, for this iteration

  INNERGS_HD void update(float& x, float& moment1, float& moment2, float gradient, float rate_) const {
    moment1 = kMomentum * moment1 + (1 - kMomentum) * gradient;
    moment2 = kScaling * moment2 + (1 - kScaling) * gradient * gradient;
    x -= rate_ * (moment1 / correction1) / (std::sqrt(moment2 / correction2) + 1e-6f);
  }
};

/// 1, T₁(u), T₂(u) for u = 2·rank − 1; the decoder treats all background ranks alike.
struct DecoderTerms {
  static constexpr int kCount = 3;
  float v[kCount];
  INNERGS_HD explicit DecoderTerms(float rank) {
    const float u = 2 * (rank > -0.3f ? rank : -0.3f) - 1;
    v[0] = 1;
    v[1] = u;
    v[2] = 2 * u * u - 1;
  }
};

} // namespace innergs
