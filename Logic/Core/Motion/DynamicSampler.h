#pragma once
#include "Core/Motion/DynamicField.h"
#include "Core/Render/PlaneSampler.h"

#include <limits>
#include <memory>

namespace innergs {

/// A continuous volume in space and time, ready to be shown on planes at times, as a dragged slice and a time
/// slider need it. The values are those of fieldAt(); while the time stays, only the plane is evaluated anew.
class DynamicSampler {
public:
  /// Throws as checkDynamicField does.
  explicit DynamicSampler(std::shared_ptr<const DynamicField> field, int threads = 0);

  /// As PlaneSampler::sample, at a time (s); not finite: Error(InvalidArgument).
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
