#pragma once
#include "Core/Device/DevicePlugin.h"
#include "Cuda/Features.h"
#include "Cuda/Field.h"
#include "Cuda/Fit.h"
#include "Cuda/FitMemory.h"

namespace innergs::cuda {

/// A plugin built on executors; a derived class lists the devices.
class ExecutorPlugin : public DevicePlugin {
public:
  /// With less than FitMemory::most, a fit works in smaller slabs.
  std::int64_t fitMemory(const FitRequest& request) override { return cuda::fitMemory(request).least; }
  std::unique_ptr<FitDevice> makeFit(int device, const FitRequest& request) override {
    return std::make_unique<Fit>(executor(device), request);
  }
  std::unique_ptr<FieldDevice> makeField(int device, const GaussianField& field) override {
    return std::make_unique<Field>(executor(device), field);
  }
  std::unique_ptr<FeatureDevice> makeFeatures(int device, const FeatureProblem& problem) override {
    return std::make_unique<Features>(executor(device), problem);
  }

protected:
  virtual std::unique_ptr<Executor> executor(int device) = 0;
};

} // namespace innergs::cuda
