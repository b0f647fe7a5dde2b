#include "Core/Motion/DynamicSampler.h"

#include "Core/Base/Error.h"

#include <cmath>

namespace innergs {

DynamicSampler::DynamicSampler(std::shared_ptr<const DynamicField> field, int threads)
    : field_(std::move(field)), threads_(threads), pool_(threads) {
  checkDynamicField(*field_);
  posed_ = std::make_shared<GaussianField>(field_->canonical);
}

void DynamicSampler::sample(const Affine3& pixelToWorld, double time, int nx, int ny, std::span<float> out,
                            const std::stop_token& stop) {
  if (!std::isfinite(time)) throw Error(ErrorCode::InvalidArgument, "The time of a plane must be finite.");
  if (!sampler_ || time != time_) {
    sampler_.reset(); // its content is about to change
    pool_.setStop(stop);
    poseAt(*field_, time, *posed_, pool_);
    sampler_ = std::make_unique<PlaneSampler>(posed_, threads_);
    time_ = time;
  }
  sampler_->sample(pixelToWorld, nx, ny, out, stop);
}

} // namespace innergs
