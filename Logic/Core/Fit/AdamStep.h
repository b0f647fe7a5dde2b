#pragma once
#include "Core/Model/Gaussian.h"
#include "Core/Model/GaussianMath.h"

namespace innergs {

/// The constants of one step of Adam (Kingma & Ba 2015), shared by all Gaussians.
struct AdamStep {
  float rate[16]; // per parameter, divided by the first moment's bias correction
  float beta1, beta2, scale2;
  float lowLogScale, highLogScale, thirdLogScale, maxAbsLogWeight;
};

/// gradient, moment1, moment2: 16 floats in the order of struct Gaussian.
INNERGS_HD inline void applyAdam(const AdamStep& step, const float* gradient, Gaussian& gaussian,
                                 float* moment1, float* moment2) {
  constexpr float tiny = 1e-12f;
  const float b1 = step.beta1, b2 = step.beta2;
  float* x = reinterpret_cast<float*>(&gaussian);
  for (int p = 0; p < 16; ++p) {
    moment1[p] = b1 * moment1[p] + (1 - b1) * gradient[p];
    moment2[p] = b2 * moment2[p] + (1 - b2) * gradient[p] * gradient[p];
    x[p] -= step.rate[p] * moment1[p] / (std::sqrt(moment2[p] * step.scale2) + tiny);
  }
  const float third = step.thirdLogScale;
  for (int k = 0; k < 3; ++k)
    gaussian.logScale[k] = math::clamped(gaussian.logScale[k], k == 2 ? third : step.lowLogScale,
                                         math::most(third, step.highLogScale));
  gaussian.logWeight = math::clamped(gaussian.logWeight, -step.maxAbsLogWeight, step.maxAbsLogWeight);
  float* q = gaussian.quaternion;
  const float n = 1 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int k = 0; k < 4; ++k)
    q[k] *= n;
}

} // namespace innergs
