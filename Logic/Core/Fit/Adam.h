#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Fit/AdamStep.h"
#include "Core/Model/GaussianField.h"

namespace innergs {

/// Learning rates by parameter group; mean in mm, slope per mm, the others in their stored units.
struct LearningRates {
  double mean = 0, logScale = 0, quaternion = 0, logWeight = 0, intensity = 0, slope = 0;

  LearningRates operator*(double share) const {
    return {mean * share,      logScale * share,  quaternion * share,
            logWeight * share, intensity * share, slope * share};
  }
};

/// Bounds that are enforced after every step.
struct FieldBounds {
  double minLogScale = -10, maxLogScale = 10;
  double minThirdLogScale = -1e9; // floor on the third axis (Docs/method.md: bridges the slice gap)
  double maxAbsLogWeight = 8;
};

/// `step` counts from 1; linear: the field has slopes.
AdamStep adamStep(const LearningRates& rates, const FieldBounds& bounds, double beta1, double beta2, int step,
                  bool linear);

/// Adam (Kingma & Ba 2015) over the 16 floats of every Gaussian.
class Adam {
public:
  explicit Adam(std::int64_t gaussians) : moment1(16 * gaussians, 0.f), moment2(16 * gaussians, 0.f) {}

  /// One step; `step` counts from 1.
  void apply(GaussianField& field, std::span<const float> gradient, const LearningRates& rates,
             const FieldBounds& bounds, int step, ThreadPool& pool);

  std::vector<float> moment1, moment2;
  double beta1 = 0.8, beta2 = 0.95;
};

} // namespace innergs
