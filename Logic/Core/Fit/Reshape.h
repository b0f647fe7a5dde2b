#pragma once
#include "Core/Model/Gaussian.h"
#include "Core/Model/GaussianMath.h"

/// What relocation and densification (Relocate.h, Densify.h) measure of one Gaussian and do to it, shared by
/// all backends.
namespace innergs::reshape {

/// DensifyPlan's thresholds in the units of the field.
struct Rules {
  Blending blending;
  double faint;      // α below which a Gaussian is pruned
  float largest;     // ln mm, above which it is pruned
  float gradient;    // sum over the iterations, above which it becomes two
  double splitAbove; // ‖Σ‖_F, mm²
  float minLogScale; // for the halves of a split
};

INNERGS_HD inline double opacity(const Gaussian& g, Blending blending) {
  const double weight = static_cast<double>(g.logWeight);
  if (blending == Blending::Alpha) return 1 / (1 + std::exp(-weight));
  const double amplitude = std::exp(weight);
  return blending == Blending::Additive ? amplitude * std::fabs(static_cast<double>(g.intensity)) : amplitude;
}

/// The longest axis; the first one of equals.
INNERGS_HD inline int longestAxis(const Gaussian& g) {
  int k = 0;
  for (int a = 1; a < 3; ++a)
    if (g.logScale[k] < g.logScale[a]) k = a;
  return k;
}

INNERGS_HD inline bool pruned(const Gaussian& g, const Rules& rules) {
  return !(opacity(g, rules.blending) >= rules.faint && g.logScale[longestAxis(g)] <= rules.largest);
}

INNERGS_HD inline double covarianceNorm(const Gaussian& g) {
  double sum = 0;
  for (int a = 0; a < 3; ++a)
    sum += std::exp(4 * static_cast<double>(g.logScale[a]));
  return std::sqrt(sum);
}

/// Sets the weight with which two equal Gaussians together blend like the original.
INNERGS_HD inline void shareWeight(Gaussian& g, Blending blending) {
  if (blending == Blending::Alpha) { // 1 − (1 − α′)² = α
    const double rest = std::sqrt(1 / (1 + std::exp(static_cast<double>(g.logWeight)))); // √(1 − α)
    g.logWeight = static_cast<float>(std::log1p(-rest) - std::log(rest));
  } else {
    g.logWeight -= 0.69314718f;
  }
}

/// A copy, shifted by half the smallest σ against the running mean of the gradient.
INNERGS_HD inline Gaussian clone(Gaussian& original, const float* moment1, Blending blending) {
  shareWeight(original, blending);
  Gaussian copy = original;
  double length = 0;
  float smallest = copy.logScale[0];
  for (int a = 0; a < 3; ++a) {
    length += static_cast<double>(moment1[a]) * static_cast<double>(moment1[a]);
    smallest = math::least(smallest, copy.logScale[a]);
  }
  length = std::sqrt(length);
  const double step = 0.5 * std::exp(static_cast<double>(smallest));
  if (length > 0)
    for (int a = 0; a < 3; ++a)
      copy.mean[a] -= static_cast<float>(step * moment1[a] / length);
  return copy;
}

/// Two halves ±0.6σ apart along the longest axis, with 0.7σ each, so that their sum stays close to the
/// original.
INNERGS_HD inline void split(const Gaussian& parent, float minLogScale, Gaussian& a, Gaussian& b) {
  float r[9];
  math::rotation(parent.quaternion, r);
  const int k = longestAxis(parent);
  const float offset = 0.6f * std::exp(parent.logScale[k]);
  a = b = parent;
  for (int i = 0; i < 3; ++i) {
    const float d = offset * r[3 * i + k];
    a.mean[i] += d;
    b.mean[i] -= d;
    const float shift = parent.slope[i] * d;
    a.intensity += shift;
    b.intensity -= shift;
  }
  a.logScale[k] = b.logScale[k] = math::most(parent.logScale[k] + std::log(0.7f), minLogScale);
}

/// Makes a second Gaussian from one; returns whether by a split.
INNERGS_HD inline bool densify(Gaussian& g, const float* moment1, const Rules& rules, Gaussian& added) {
  if (!(covarianceNorm(g) > rules.splitAbove)) {
    added = clone(g, moment1, rules.blending);
    return false;
  }
  const Gaussian parent = g;
  split(parent, rules.minLogScale, g, added);
  if (rules.blending == Blending::Additive) { // two halves of 0.7 of the length sum to 1.4 of the original
    g.logWeight -= 0.3364722f;
    added.logWeight -= 0.3364722f;
  }
  return true;
}

/// Positional gradient relative to the size, from Adam's running mean of squared gradients.
INNERGS_HD inline float splitPriority(const Gaussian& g, const float* moment2) {
  const float scale = std::exp((g.logScale[0] + g.logScale[1] + g.logScale[2]) / 3);
  return (moment2[0] + moment2[1] + moment2[2]) * scale * scale;
}

/// How strongly the residual acts on the intensity.
INNERGS_HD inline float influence(const float* moment2) {
  return moment2[11];
}

} // namespace innergs::reshape
