#include "Core/FieldGradient.h"

namespace innergs {
namespace {

void symmetricTimes(const float* s, const float* x, float* y) {
  y[0] = s[0] * x[0] + s[1] * x[1] + s[2] * x[2];
  y[1] = s[1] * x[0] + s[3] * x[1] + s[4] * x[2];
  y[2] = s[2] * x[0] + s[4] * x[1] + s[5] * x[2];
}

void unpack(const float* s, float* full) {
  const float m[9] = {s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5]};
  for (int i = 0; i < 9; ++i)
    full[i] = m[i];
}

void covarianceAndPrecision(const Gaussian& g, float* covariance, float* precision) {
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

/// ∂L/∂P (Σ's own precision) from ∂L/∂P_obs and ∂L/∂(log weight), G_Σ = −P_obs G P_obs + ½ m0 (P − P_obs),
/// ∂L/∂P = −Σ G_Σ Σ.
void throughPsf(const float* covariance, const float* precision, const float* observed, float m0, float* g6) {
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

} // namespace

FieldGradient::FieldGradient(const GaussianField& field, const Lattice& lattice, const ClosedFormPsf& psf)
    : linear_(field.linearIntensity), alpha_(field.blending == Blending::Alpha), psf_(psf) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      toModel_[3 * i + j] = static_cast<float>(lattice.indexToModel.linear[i][j]);
}

void FieldGradient::add(const Gaussian& g, const math::Moments<float>& moments, float* gradient) const {
  const math::Moments<float> m = math::transformMoments(moments, toModel_);
  float covariance[6], precision[6], observed[6];
  covarianceAndPrecision(g, covariance, precision);
  if (psf_.active) {
    float sum[6];
    for (int i = 0; i < 6; ++i)
      sum[i] = covariance[i] + psf_.covariance[i];
    math::invertSymmetric(sum, observed);
  }
  float dMean[3], g6[6], dLogScale[3], dQuaternion[4];
  symmetricTimes(psf_.active ? observed : precision, m.m1, dMean);
  for (int i = 0; i < 6; ++i)
    g6[i] = -0.5f * m.m2[i];
  if (psf_.active) throughPsf(covariance, precision, observed, m.m0, g6);
  math::precisionGradient(g6, g.logScale, g.quaternion, dLogScale, dQuaternion);
  for (int i = 0; i < 3; ++i) {
    gradient[i] += dMean[i] - (linear_ ? g.slope[i] * m.n0 : 0.f);
    gradient[3 + i] += dLogScale[i];
    if (linear_) gradient[12 + i] += m.n1[i];
  }
  for (int i = 0; i < 4; ++i)
    gradient[6 + i] += dQuaternion[i];
  gradient[10] += alpha_ ? m.m0 / (1 + std::exp(g.logWeight)) : m.m0; // ∂α/∂logit = α(1 − α)
  gradient[11] += m.n0;
}

} // namespace innergs
