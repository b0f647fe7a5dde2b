#pragma once
#include "Core/Model/GaussianMath.h"
#include "Core/Render/Projection.h"

namespace innergs {

/// Inputs of the chain rule that all Gaussians of a grid share.
struct ChainRules {
  float toModel[9]; // d(model)/d(index)
  bool linear = false, alpha = false;
  ClosedFormPsf psf;
};

namespace chain {

INNERGS_HD inline void symmetricTimes(const float* s, const float* x, float* y) {
  y[0] = s[0] * x[0] + s[1] * x[1] + s[2] * x[2];
  y[1] = s[1] * x[0] + s[3] * x[1] + s[4] * x[2];
  y[2] = s[2] * x[0] + s[4] * x[1] + s[5] * x[2];
}

INNERGS_HD inline void unpack(const float* s, float* full) {
  const float m[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
  for (int i = 0; i < 9; ++i)
    full[i] = m[i];
}

INNERGS_HD inline void covarianceAndPrecision(const Gaussian& g, float* covariance, float* precision) {
  float r[9], scaled[9], whitened[9];
  math::rotation(g.quaternion, r);
  for (int k = 0; k < 3; ++k) {
    const float s = std::exp(g.logScale[k]);
    for (int i = 0; i < 3; ++i) {
      scaled[3 * i + k] = r[3 * i + k] * s;
      whitened[3 * i + k] = r[3 * i + k] / s;
    }
  }
  math::outer(scaled, covariance);
  math::outer(whitened, precision);
}

/// ∂L/∂P (P: Σ's own inverse) from ∂L/∂P_obs and ∂L/∂(log weight): G_Σ = −P_obs G P_obs + ½ m0 (P − P_obs),
/// ∂L/∂P = −Σ G_Σ Σ.
INNERGS_HD inline void throughPsf(const float* covariance, const float* precision, const float* observed,
                                  float m0, float* g6) {
  float p[9], g[9], t[9], sigma[9], gs[9];
  unpack(observed, p);
  unpack(g6, g);
  unpack(covariance, sigma);
  math::multiply(p, g, t);
  math::multiply(t, p, gs);
  float own[9];
  unpack(precision, own);
  for (int i = 0; i < 9; ++i)
    gs[i] = -gs[i] + 0.5f * m0 * (own[i] - p[i]);
  math::multiply(sigma, gs, t);
  math::multiply(t, sigma, g);
  int n = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      g6[n++] = -g[3 * i + j];
}

} // namespace chain

/// From a Gaussian's moments on a grid to its 15 parameters (Docs/method.md; closed-form PSF: through
/// Σ_obs = Σ + B and the factor √(det Σ / det Σ_obs)). Adds to gradient[16], in the order of struct Gaussian.
INNERGS_HD inline void addParameterGradient(const Gaussian& g, const math::Moments<float>& moments,
                                            const ChainRules& rules, float* gradient) {
  using namespace chain;
  const math::Moments<float> m = math::transformMoments(moments, rules.toModel);
  float covariance[6], precision[6], observed[6];
  covarianceAndPrecision(g, covariance, precision);
  if (rules.psf.active) {
    float sum[6];
    for (int i = 0; i < 6; ++i)
      sum[i] = covariance[i] + rules.psf.covariance[i];
    math::invertSymmetric(sum, observed);
  }
  float dMean[3], g6[6], dLogScale[3], dQuaternion[4];
  symmetricTimes(rules.psf.active ? observed : precision, m.m1, dMean);
  for (int i = 0; i < 6; ++i)
    g6[i] = -0.5f * m.m2[i];
  if (rules.psf.active) throughPsf(covariance, precision, observed, m.m0, g6);
  math::precisionGradient(g6, g.logScale, g.quaternion, dLogScale, dQuaternion);
  for (int i = 0; i < 3; ++i) {
    gradient[i] += dMean[i] - (rules.linear ? g.slope[i] * m.n0 : 0.f);
    gradient[3 + i] += dLogScale[i];
    if (rules.linear) gradient[12 + i] += m.n1[i];
  }
  for (int i = 0; i < 4; ++i)
    gradient[6 + i] += dQuaternion[i];
  gradient[10] += rules.alpha ? m.m0 / (1 + std::exp(g.logWeight)) : m.m0; // ∂α/∂logit = α(1 − α)
  gradient[11] += m.n0;
}

} // namespace innergs
