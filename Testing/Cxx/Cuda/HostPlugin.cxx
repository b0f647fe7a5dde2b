// A device plugin whose single device is the host executor: the kernels behind the program's own loader.
#include "Cuda/HostExecutor.h"
#include "Cuda/Plugin.h"

namespace {

using namespace innergs;

class HostPlugin final : public cuda::ExecutorPlugin {
public:
  DeviceList devices() override {
    constexpr std::int64_t memory = std::int64_t{1} << 36;
    return {{{"Host executor", "0.0", memory, 0, {}}}, ""};
  }
  std::int64_t freeMemory(int) override { return std::int64_t{1} << 36; }

protected:
  std::unique_ptr<cuda::Executor> executor(int) override { return cuda::makeHostExecutor(); }
};

} // namespace

INNERGS_DEVICE_PLUGIN(HostPlugin)
