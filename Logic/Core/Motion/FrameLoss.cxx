#include "Core/Motion/FrameLoss.h"

#include "Core/Base/Error.h"
#include "Core/Fit/CpuFitDevice.h"

#include <algorithm>
#include <optional>
#include <utility>

namespace innergs {

FrameLoss::FrameLoss(std::vector<Observation> frames, const KernelSet& kernels, ThreadPool& pool,
                     DeviceChoice* device)
    : kernels_(kernels), pool_(pool), choice_(device) {
  request_.observations = std::make_shared<const std::vector<Observation>>(std::move(frames));
  request_.stop = pool.stopToken();
}

void FrameLoss::place(const GaussianField& field) {
  if (device_ && (onCpu_ || !choice_->onCpu())) return;
  device_.reset(); // first, for its memory
  request_.blending = field.blending;
  request_.linearIntensity = field.linearIntensity;
  request_.gaussians = field.size();
  if (choice_) device_ = choice_->makeFit(request_);
  onCpu_ = !device_;
  if (onCpu_) device_ = std::make_unique<CpuFitDevice>(request_, kernels_, pool_);
}

double FrameLoss::operator()(const GaussianField& field, std::int64_t frame, std::span<float> gradient) {
  place(field);
  std::optional<std::string> why;
  LossSum sum;
  try {
    sum = device_->gradient(field, frame, gradient);
    if (!onCpu_) choice_->note(device_->remark());
  } catch (const Error& error) {
    if (onCpu_ || error.code() == ErrorCode::Cancelled) throw;
    why = error.what();
  } catch (const std::exception& error) {
    if (onCpu_) throw;
    why = error.what();
  }
  if (why) {
    choice_->failed("on frame " + std::to_string(frame + 1) + ", and the fit continued", *why);
    place(field);
    sum = device_->gradient(field, frame, gradient);
  }
  return sum.squared / static_cast<double>(std::max<std::int64_t>(1, sum.samples));
}

} // namespace innergs
