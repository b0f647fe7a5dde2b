#include "Core/Adam.h"

#include <algorithm>
#include <cmath>

namespace innergs {

void Adam::apply(GaussianField& field, std::span<const float> gradient, const LearningRates& rates,
                 const FieldBounds& bounds, int step, ThreadPool& pool) {
  const double slope = field.linearIntensity ? rates.slope : 0;
  const double perParameter[16] = {rates.mean,
                                   rates.mean,
                                   rates.mean,
                                   rates.logScale,
                                   rates.logScale,
                                   rates.logScale,
                                   rates.quaternion,
                                   rates.quaternion,
                                   rates.quaternion,
                                   rates.quaternion,
                                   rates.logWeight,
                                   rates.intensity,
                                   slope,
                                   slope,
                                   slope,
                                   0};
  const double correction1 = 1 - std::pow(beta1, step), correction2 = 1 - std::pow(beta2, step);
  std::array<float, 16> rate;
  for (int p = 0; p < 16; ++p)
    rate[p] = static_cast<float>(perParameter[p] / correction1);
  const float b1 = static_cast<float>(beta1), b2 = static_cast<float>(beta2);
  const float scale2 = static_cast<float>(1 / correction2), tiny = 1e-12f;
  const float low = static_cast<float>(bounds.minLogScale), high = static_cast<float>(bounds.maxLogScale);
  const float third = static_cast<float>(std::max(bounds.minLogScale, bounds.minThirdLogScale));
  const float weight = static_cast<float>(bounds.maxAbsLogWeight);
  constexpr std::int64_t kBlock = 4096;
  pool.runToEnd((field.size() + kBlock - 1) / kBlock, [&](std::int64_t block) {
    for (std::int64_t i = block * kBlock; i < std::min(field.size(), (block + 1) * kBlock); ++i) {
      float* x = reinterpret_cast<float*>(&field.gaussians[i]);
      const float* g = gradient.data() + 16 * i;
      float* m = moment1.data() + 16 * i;
      float* v = moment2.data() + 16 * i;
      for (int p = 0; p < 16; ++p) {
        m[p] = b1 * m[p] + (1 - b1) * g[p];
        v[p] = b2 * v[p] + (1 - b2) * g[p] * g[p];
        x[p] -= rate[p] * m[p] / (std::sqrt(v[p] * scale2) + tiny);
      }
      Gaussian& gaussian = field.gaussians[i];
      for (int k = 0; k < 3; ++k)
        gaussian.logScale[k] = std::clamp(gaussian.logScale[k], k == 2 ? third : low, std::max(third, high));
      gaussian.logWeight = std::clamp(gaussian.logWeight, -weight, weight);
      float* q = gaussian.quaternion;
      const float n = 1 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
      for (int k = 0; k < 4; ++k)
        q[k] *= n;
    }
  });
}

} // namespace innergs
