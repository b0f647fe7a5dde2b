#pragma once
#include "Core/Motion/DynamicField.h"
#include "Core/Render/PlaneSampler.h"

#include <limits>
#include <memory>

namespace innergs {

/// Shows a continuous volume in space and time on planes at given times, as for a dragged slice and a time
/// slider. Values are the same as fieldAt()'s; while the time stays the same, only the plane is evaluated.
class DynamicSampler {
public:
  /// Throws like checkDynamicField.
  explicit DynamicSampler(std::shared_ptr<const DynamicField> field, int threads = 0);

  /// Like PlaneSampler::sample, at a time (s); if it is not finite: Error(InvalidArgument).
  void sample(const Affine3& pixelToWorld, double time, int nx, int ny, std::span<float> out,
              const std::stop_token& stop = {});

private:
  std::shared_ptr<const DynamicField> field_;
  int threads_;
  ThreadPool pool_;
  std::shared_ptr<GaussianField> posed_;
  std::unique_ptr<PlaneSampler> sampler_; // of posed_
  double time_ = std::numeric_limits<double>::quiet_NaN();
};

} // namespace innergs
