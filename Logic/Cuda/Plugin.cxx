#include "Cuda/Plugin.h"

#include "Cuda/CudaExecutor.h"

namespace innergs::cuda {
namespace {

class Plugin final : public ExecutorPlugin {
public:
  DeviceList devices() override { return cudaDevices(); }
  std::int64_t freeMemory(int device) override { return cudaFreeMemory(device); }

protected:
  std::unique_ptr<Executor> executor(int device) override { return makeCudaExecutor(device); }
};

} // namespace
} // namespace innergs::cuda

INNERGS_DEVICE_PLUGIN(innergs::cuda::Plugin)
