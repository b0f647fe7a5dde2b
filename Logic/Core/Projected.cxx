#include "Core/Projected.h"

#include "Core/GaussianMath.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr float kLog2e = 1.44269504088896340736f;
constexpr float kReach = 1e9f;       // index units: limits of rows and columns stay within an int
constexpr float kLowestCut = -120.f; // the kernels' exp2 needs a normal result
constexpr float kNothing = -1e30f;   // weight of a Gaussian too degenerate to be seen

struct Frame {
  float toIndex[9], toModelT[9]; // d(index)/d(model), (d(model)/d(index))ᵀ
  double inverse[9], offset[3];
};

Frame makeFrame(const Lattice& lattice) {
  Frame f;
  const Affine3 inv = inverse(lattice.indexToModel);
  for (int i = 0; i < 3; ++i) {
    f.offset[i] = inv.offset[i];
    for (int j = 0; j < 3; ++j) {
      f.inverse[3 * i + j] = inv.linear[i][j];
      f.toIndex[3 * i + j] = static_cast<float>(inv.linear[i][j]);
      f.toModelT[3 * i + j] = static_cast<float>(lattice.indexToModel.linear[j][i]);
    }
  }
  return f;
}

/// ln of the weight: of α = 1/(1 + e^(−logit)) where blending is alpha.
float logAmplitude(const Gaussian& g, Blending blending) {
  return blending == Blending::Alpha ? -std::log1p(std::exp(-g.logWeight)) : g.logWeight;
}

constexpr float kPaperReach = 3; // σ, of both methods of the paper

void selectCube(const float* covariance, Projected& o) {
  const float edge = kPaperReach * std::sqrt(math::largestEigenvalue(covariance));
  std::fill_n(o.half, 3, std::min(kReach, edge));
}

void selectSquares(const float* covariance, Projected& o) {
  const auto slice = math::sliceConditional(covariance);
  const float* c = slice.covariance;
  const float mean = 0.5f * (c[0] + c[2]), difference = 0.5f * (c[0] - c[2]);
  const float eigenvalue = mean + std::sqrt(difference * difference + c[1] * c[1]);
  const float reach = kPaperReach * std::sqrt(slice.variance);
  o.square = std::min(kReach, kPaperReach * std::sqrt(std::max(eigenvalue, 0.f)));
  o.shiftXZ = slice.shift[0];
  o.half[2] = std::min(kReach, reach);
  for (int i = 0; i < 2; ++i)
    o.half[i] = std::min(kReach, std::fabs(slice.shift[i]) * reach + o.square);
}

void projectOne(const Gaussian& g, const Frame& f, float radius2, Blending blending, const ClosedFormPsf& psf,
                Selection selection, Projected& o) {
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
  float logWeight = logAmplitude(g, blending);
  if (psf.active) {
    double exact[9], blurred[6], inverse[6];
    float t[9], m[9];
    std::copy_n(scaled, 9, exact);
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
  o.precisionY = std::max(form.b, radius2 / (kReach * kReach));
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
  o.log2Cut = std::max(o.log2Weight + k * radius2, kLowestCut);
  o.cut = std::exp2(o.log2Cut);
  o.half[0] = std::min(kReach, std::sqrt(radius2 * covariance[0]));
  o.half[1] = std::min(kReach, std::sqrt(radius2 * covariance[3]));
  o.half[2] = std::min(kReach, std::sqrt(radius2 * covariance[5]));
  o.shiftXZ = o.square = 0;
  if (selection == Selection::Method1) selectCube(covariance, o);
  if (selection == Selection::Method2) selectSquares(covariance, o);
  for (int i = 0; i < 3; ++i) {
    double x = f.offset[i];
    for (int j = 0; j < 3; ++j)
      x += f.inverse[3 * i + j] * static_cast<double>(g.mean[j]);
    x = std::clamp(x, -1e8, 1e8);
    const double cell = std::floor(x);
    o.cell[i] = static_cast<std::int32_t>(cell);
    o.fraction[i] = static_cast<float>(x - cell);
  }
}

} // namespace

void project(const GaussianField& field, std::span<const float> values, const Lattice& lattice,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out, Selection selection) {
  const Frame frame = makeFrame(lattice);
  const float radius2 = static_cast<float>(field.cutoff * field.cutoff);
  out.resize(field.gaussians.size());
  pool.blocks(field.size(), 2048, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const Gaussian& g = field.gaussians[i];
      Projected& o = out[i];
      projectOne(g, frame, radius2, field.blending, psf, selection, o);
      o.value = values.empty() ? g.intensity : values[i];
      for (int k = 0; k < 3; ++k) {
        const float* t = frame.toModelT + 3 * k;
        o.slope[k] = values.empty() && field.linearIntensity
                         ? t[0] * g.slope[0] + t[1] * g.slope[1] + t[2] * g.slope[2]
                         : 0.f;
      }
    }
  });
}

} // namespace innergs
