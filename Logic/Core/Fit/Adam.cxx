#include "Core/Fit/Adam.h"

#include <algorithm>
#include <cmath>

namespace innergs {

AdamStep adamStep(const LearningRates& rates, const FieldBounds& bounds, double beta1, double beta2, int step,
                  bool linear) {
  const double slope = linear ? rates.slope : 0;
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
  AdamStep s;
  for (int p = 0; p < 16; ++p)
    s.rate[p] = static_cast<float>(perParameter[p] / correction1);
  s.beta1 = static_cast<float>(beta1);
  s.beta2 = static_cast<float>(beta2);
  s.scale2 = static_cast<float>(1 / correction2);
  s.lowLogScale = static_cast<float>(bounds.minLogScale);
  s.highLogScale = static_cast<float>(bounds.maxLogScale);
  s.thirdLogScale = static_cast<float>(std::max(bounds.minLogScale, bounds.minThirdLogScale));
  s.maxAbsLogWeight = static_cast<float>(bounds.maxAbsLogWeight);
  return s;
}

void Adam::apply(GaussianField& field, std::span<const float> gradient, const LearningRates& rates,
                 const FieldBounds& bounds, int step, ThreadPool& pool) {
  const AdamStep s = adamStep(rates, bounds, beta1, beta2, step, field.linearIntensity);
  constexpr std::int64_t kBlock = 4096;
  pool.runToEnd((field.size() + kBlock - 1) / kBlock, [&](std::int64_t block) {
    for (std::int64_t i = block * kBlock; i < std::min(field.size(), (block + 1) * kBlock); ++i)
      applyAdam(s, gradient.data() + 16 * i, field.gaussians[i], moment1.data() + 16 * i,
                moment2.data() + 16 * i);
  });
}

} // namespace innergs
