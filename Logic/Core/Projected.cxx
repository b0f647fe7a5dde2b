#include "Core/Projected.h"

#include "Core/GaussianMath.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr float kLog2e = 1.44269504088896340736f;

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

void projectOne(const Gaussian& g, const Frame& f, float radius2, const ClosedFormPsf& psf, Projected& o) {
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
  float logWeight = g.logWeight;
  if (psf.active) {
    float model[6], observed[9], t[9];
    math::outer(scaled, model);
    float logDet = 2 * (g.logScale[0] + g.logScale[1] + g.logScale[2]);
    for (int i = 0; i < 6; ++i)
      model[i] += psf.covariance[i];
    const float det = math::invertSymmetric(model, precision);
    logWeight += 0.5f * (logDet - std::log(det));
    const float full[9] = {model[0], model[1], model[2], model[1], model[3],
                           model[4], model[2], model[4], model[5]};
    math::multiply(f.toIndex, full, observed);
    math::transposed(f.toIndex, t);
    math::multiply(observed, t, s);
    covariance[0] = s[0], covariance[3] = s[4], covariance[5] = s[8];
    const float pf[9] = {precision[0], precision[1], precision[2], precision[1], precision[3],
                         precision[4], precision[2], precision[4], precision[5]};
    math::multiply(f.toModelT, pf, observed);
    math::transposed(f.toModelT, t);
    math::multiply(observed, t, s);
    precision[0] = s[0], precision[1] = s[1], precision[2] = s[2];
    precision[3] = s[4], precision[4] = s[5], precision[5] = s[8];
  } else {
    math::multiply(f.toIndex, scaled, s);
    math::outer(s, covariance);
    math::multiply(f.toModelT, whitened, s);
    math::outer(s, precision);
  }
  const auto form = math::rowForm(precision);
  o.precisionY = form.b;
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
  o.log2Weight = logWeight * kLog2e;
  o.log2Cut = o.log2Weight + k * radius2;
  o.cut = std::exp2(o.log2Cut);
  o.half[0] = std::sqrt(radius2 * covariance[0]);
  o.half[1] = std::sqrt(radius2 * covariance[3]);
  o.half[2] = std::sqrt(radius2 * covariance[5]);
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
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out) {
  const Frame frame = makeFrame(lattice);
  const float radius2 = static_cast<float>(field.cutoff * field.cutoff);
  out.resize(field.gaussians.size());
  pool.blocks(field.size(), 2048, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const Gaussian& g = field.gaussians[i];
      Projected& o = out[i];
      projectOne(g, frame, radius2, psf, o);
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
