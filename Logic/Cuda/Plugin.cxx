#include "Core/DevicePlugin.h"

#include "Cuda/CudaExecutor.h"
#include "Cuda/Field.h"
#include "Cuda/Fit.h"

namespace innergs::cuda {
namespace {

class Plugin final : public DevicePlugin {
public:
  DeviceList devices() override { return cudaDevices(); }
  // With less than FitMemory::most it works in smaller slabs.
  std::int64_t fitMemory(const FitRequest& request) override { return cuda::fitMemory(request).least; }
  std::unique_ptr<FitDevice> makeFit(int device, const FitRequest& request) override {
    return std::make_unique<Fit>(makeCudaExecutor(device), request);
  }
  std::unique_ptr<FieldDevice> makeField(int device, const GaussianField& field) override {
    return std::make_unique<Field>(makeCudaExecutor(device), field);
  }
};

} // namespace
} // namespace innergs::cuda

INNERGS_DEVICE_PLUGIN(innergs::cuda::Plugin)
