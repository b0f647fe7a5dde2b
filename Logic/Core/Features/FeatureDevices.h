#pragma once
#include "Core/Features/FeatureDevice.h"

#include <memory>
#include <stop_token>
#include <string>

namespace innergs {

/// Where the iterations run: Device/FeatureDeviceChoice.h.
class FeatureDevices {
public:
  virtual ~FeatureDevices() = default;
  /// Null for the CPU. Throws Error(Cancelled).
  virtual std::unique_ptr<FeatureDevice> make(const FeatureProblem& problem, int iterations,
                                              const std::stop_token& stop) = 0;
  /// Says why the device is not used: the CPU starts over.
  virtual void failed(const std::string& why) = 0;
};

} // namespace innergs
