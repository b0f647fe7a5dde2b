#pragma once
#include "Core/Acquisition/ClosedFormPsf.h"
#include "Core/Model/Gaussian.h"
#include "Core/Model/GaussianMath.h"
#include "Core/Settings/Selection.h"

namespace innergs {

/// One Gaussian in a grid's index coordinates (Σ' = J Σ Jᵀ as in EWA splatting, Zwicker et al. 2001, with the
/// grid's constant J), ready for the kernels. The mean is cell + fraction, so that distances to voxels keep
/// full float precision. Exponents are base 2: w·p = exp2(quadratic(d) + log2Weight).
struct Projected {
  std::int32_t cell[3];
  float fraction[3];
  float quadratic[6];                    // −½·log2(e)·P with the mixed terms doubled: xx xy xz yy yz zz
  float log2Weight;                      // alpha blending: log2 α
  float log2Cut;                         // exponent at the cut-off radius, including the weight
  float cut;                             // w·p at the cut-off: subtracted, so that p is continuous
  float value;                           // c
  float slope[3];                        // g per index step
  float radius2;                         // squared cut-off (Mahalanobis)
  float precisionY, shiftYZ, precisionZ; // row form: b, l3, 1/Σzz
  float half[3]; // half extents that the selection covers (Exact: of the cut-off ellipsoid), index units
  float shiftXZ, square; // Method2: conditional mean of x per step of z; half edge of its square at dz = 0
};

/// Converts from the model frame to a grid's indices, for projectGaussian().
struct ProjectionFrame {
  float toIndex[9], toModelT[9]; // d(index)/d(model), (d(model)/d(index))ᵀ
  double inverse[9], offset[3];
};

/// Inputs of the projection that all Gaussians of a grid share.
struct ProjectionRules {
  float radius2 = 0; // squared cut-off (Mahalanobis)
  Blending blending = Blending::Normalised;
  bool linear = false;
  Selection selection = Selection::Exact;
  ClosedFormPsf psf;
};

namespace projection {

constexpr float kLog2e = 1.44269504088896340736f;
constexpr float kIndexLimit = 1e9f;  // index units: keeps the limits of rows and columns within an int
constexpr float kLowestCut = -120.f; // the kernels' exp2 needs a normal result
constexpr float kNothing = -1e30f;   // weight of a Gaussian too degenerate to be visible

/// ln of the weight, or of α = 1/(1 + e^(−logit)) for alpha blending.
INNERGS_HD inline float logAmplitude(const Gaussian& g, Blending blending) {
  return blending == Blending::Alpha ? -std::log1p(std::exp(-g.logWeight)) : g.logWeight;
}

constexpr float kPaperReach = 3; // σ, in both of the paper's methods

INNERGS_HD inline void selectCube(const float* covariance, Projected& o) {
  // Slightly enlarged, so that rounding does not lose points on a face.
  const float edge = kPaperReach * std::sqrt(math::largestEigenvalue(covariance)) * 1.00002f + 1e-4f;
  for (float& half : o.half)
    half = math::least(kIndexLimit, edge);
}

INNERGS_HD inline void selectSquares(const float* covariance, Projected& o) {
  const auto slice = math::sliceConditional(covariance);
  const float* c = slice.covariance;
  const float mean = 0.5f * (c[0] + c[2]), difference = 0.5f * (c[0] - c[2]);
  const float eigenvalue = mean + std::sqrt(difference * difference + c[1] * c[1]);
  const float reach = kPaperReach * std::sqrt(slice.variance);
  o.square = math::least(kIndexLimit, kPaperReach * std::sqrt(math::most(eigenvalue, 0.f)));
  o.shiftXZ = slice.shift[0];
  o.half[2] = math::least(kIndexLimit, reach);
  for (int i = 0; i < 2; ++i)
    o.half[i] = math::least(kIndexLimit, std::fabs(slice.shift[i]) * reach + o.square);
}

} // namespace projection

/// `value`: replaces intensity and slope if not null.
INNERGS_HD inline void projectGaussian(const Gaussian& g, const float* value, const ProjectionFrame& f,
                                       const ProjectionRules& rules, Projected& o) {
  using namespace projection;
  const float radius2 = rules.radius2;
  const ClosedFormPsf& psf = rules.psf;
  float r[9], s[9], covariance[6], precision[6];
  math::rotation(g.quaternion, r);
  float scaled[9], whitened[9];
  for (int k = 0; k < 3; ++k) {
    const float scale = std::exp(g.logScale[k]), inv = 1 / scale;
    for (int i = 0; i < 3; ++i) {
      scaled[3 * i + k] = r[3 * i + k] * scale;
      whitened[3 * i + k] = r[3 * i + k] * inv;
    }
  }
  float logWeight = logAmplitude(g, rules.blending);
  if (psf.active) {
    double exact[9], blurred[6], inverse[6];
    float t[9], m[9];
    for (int i = 0; i < 9; ++i)
      exact[i] = scaled[i];
    math::outer(exact, blurred);
    for (int i = 0; i < 6; ++i)
      blurred[i] += static_cast<double>(psf.covariance[i]);
    const double det = math::invertSymmetric(blurred, inverse);
    logWeight += g.logScale[0] + g.logScale[1] + g.logScale[2] - static_cast<float>(0.5 * std::log(det));
    const auto congruent = [&](const float* a, const double* c, float* out) { // a·c·aᵀ
      const float full[9] = {float(c[0]), float(c[1]), float(c[2]), float(c[1]), float(c[3]),
                             float(c[4]), float(c[2]), float(c[4]), float(c[5])};
      math::multiply(a, full, m);
      math::transposed(a, t);
      math::multiply(m, t, s);
      out[0] = s[0], out[1] = s[1], out[2] = s[2], out[3] = s[4], out[4] = s[5], out[5] = s[8];
    };
    congruent(f.toIndex, blurred, covariance);
    congruent(f.toModelT, inverse, precision);
  } else {
    math::multiply(f.toIndex, scaled, s);
    math::outer(s, covariance);
    math::multiply(f.toModelT, whitened, s);
    math::outer(s, precision);
  }
  const auto form = math::rowForm(precision);
  o.precisionY = math::most(form.b, radius2 / (kIndexLimit * kIndexLimit));
  o.shiftYZ = form.l3;
  o.precisionZ = 1 / covariance[5];
  o.radius2 = radius2;
  const float k = -0.5f * kLog2e;
  o.quadratic[0] = k * precision[0];
  o.quadratic[1] = 2 * k * precision[1];
  o.quadratic[2] = 2 * k * precision[2];
  o.quadratic[3] = k * precision[3];
  o.quadratic[4] = 2 * k * precision[4];
  o.quadratic[5] = k * precision[5];
  o.log2Weight = std::isfinite(logWeight) ? logWeight * kLog2e : kNothing;
  o.log2Cut = math::most(o.log2Weight + k * radius2, kLowestCut);
  o.cut = std::exp2(o.log2Cut);
  o.half[0] = math::least(kIndexLimit, std::sqrt(radius2 * covariance[0]));
  o.half[1] = math::least(kIndexLimit, std::sqrt(radius2 * covariance[3]));
  o.half[2] = math::least(kIndexLimit, std::sqrt(radius2 * covariance[5]));
  o.shiftXZ = o.square = 0;
  if (rules.selection == Selection::Method1) selectCube(covariance, o);
  if (rules.selection == Selection::Method2) selectSquares(covariance, o);
  for (int i = 0; i < 3; ++i) {
    double x = f.offset[i];
    for (int j = 0; j < 3; ++j)
      x += f.inverse[3 * i + j] * static_cast<double>(g.mean[j]);
    x = math::clamped(x, -1e8, 1e8);
    const double cell = std::floor(x);
    o.cell[i] = static_cast<std::int32_t>(cell);
    o.fraction[i] = static_cast<float>(x - cell);
  }
  o.value = value ? *value : g.intensity;
  for (int i = 0; i < 3; ++i) {
    const float* t = f.toModelT + 3 * i;
    o.slope[i] = !value && rules.linear ? t[0] * g.slope[0] + t[1] * g.slope[1] + t[2] * g.slope[2] : 0.f;
  }
}

} // namespace innergs
