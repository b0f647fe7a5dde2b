#pragma once
#include "Core/Model/GaussianMath.h"
#include "Core/Settings/LossKind.h"

#include <array>

namespace innergs {

/// Loss of one sample and its derivative.
INNERGS_HD inline float pointLoss(LossKind kind, float delta, float e, float& derivative) {
  const float a = std::fabs(e);
  switch (kind) {
  case LossKind::L1:
    derivative = e > 0 ? 1.f : e < 0 ? -1.f : 0.f;
    return a;
  case LossKind::Huber:
    derivative = a <= delta ? e : (e > 0 ? delta : -delta);
    return a <= delta ? 0.5f * e * e : delta * (a - 0.5f * delta);
  case LossKind::L2:
    break;
  }
  derivative = e;
  return 0.5f * e * e;
}

constexpr int kSsimRadius = 5, kSsimWidth = 2 * kSsimRadius + 1;

/// A Gaussian window of σ = 1.5 pixels; the weights sum to 1.
inline std::array<float, kSsimWidth> ssimWindow() {
  std::array<float, kSsimWidth> w;
  float sum = 0;
  for (int i = -kSsimRadius; i <= kSsimRadius; ++i)
    sum += w[i + kSsimRadius] = std::exp(-0.5f * i * i / (1.5f * 1.5f));
  for (float& x : w)
    x /= sum;
  return w;
}

/// SSIM of one pixel from the filtered images and products, for intensities in [0, 1], with its derivatives
/// by the filtered image x, x² and xy.
struct SsimTerm {
  float ssim, dMean, dSquare, dProduct;
};

INNERGS_HD inline SsimTerm ssimTerm(float mx, float my, float xx, float yy, float xy) {
  constexpr float c1 = 0.01f * 0.01f, c2 = 0.03f * 0.03f;
  const float a1 = 2 * mx * my + c1, a2 = 2 * (xy - mx * my) + c2;
  const float b1 = mx * mx + my * my + c1;
  const float b2 = xx - mx * mx + yy - my * my + c2;
  SsimTerm t;
  t.ssim = a1 * a2 / (b1 * b2);
  t.dMean = 2 * my * (a2 - a1) / (b1 * b2) - 2 * mx * t.ssim * (1 / b1 - 1 / b2);
  t.dSquare = -t.ssim / b2;
  t.dProduct = 2 * a1 / (b1 * b2);
  return t;
}

} // namespace innergs
