#include "Core/Device/FeatureDeviceChoice.h"

namespace innergs {

std::unique_ptr<FeatureDevice> FeatureDeviceChoice::make(const FeatureProblem& problem, int iterations,
                                                         const std::stop_token& stop) {
  choice_.considerSize(static_cast<double>(problem.rows->voxels.size()), iterations);
  return choice_.makeFeatures(problem, stop);
}

void FeatureDeviceChoice::failed(const std::string& why) {
  choice_.failed("while learning, and the CPU started over", why);
}

} // namespace innergs
