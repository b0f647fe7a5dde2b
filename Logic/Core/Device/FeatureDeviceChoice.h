#pragma once
#include "Core/Device/Devices.h"
#include "Core/Features/FeatureDevices.h"

namespace innergs {

/// The device for the iterations of trainFeatures(). "auto" leaves small ones on the CPU.
class FeatureDeviceChoice final : public FeatureDevices {
public:
  /// Throws like DeviceChoice.
  explicit FeatureDeviceChoice(const std::string& asked) : choice_(asked) {}

  std::unique_ptr<FeatureDevice> make(const FeatureProblem& problem, int iterations,
                                      const std::stop_token& stop) override;
  void failed(const std::string& why) override;
  /// Where they ran, and why there.
  const DeviceUse& use() const { return choice_.use; }

private:
  DeviceChoice choice_;
};

} // namespace innergs
