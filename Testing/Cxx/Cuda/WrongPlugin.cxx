// A device plugin whose devices run the kernels on the host, all but the last one wrongly.
// INNERGS_WRONG: "alone" omits the good one, "busy" lets none start, "asleep" ends the program when one
// starts, "gated" creates the file INNERGS_WRONG_GATE.entered and starts a device once there is a file
// INNERGS_WRONG_GATE.open. INNERGS_WRONG_LOG: a file to which every start appends a line with the device's
// number.
#include "Core/Base/Error.h"
#include "Cuda/HostBlock.h"
#include "Cuda/HostExecutor.h"
#include "Cuda/Plugin.h"
#include "RunOnHost.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <type_traits>

namespace {

using namespace innergs;
using namespace innergs::cuda;

/// Never renders the last brick or tile of an image.
struct LosesBlocks {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    constexpr bool renders = std::is_same_v<Kernel, Accumulate> || std::is_same_v<Kernel, Composite>;
    runOnHost(kernel, renders ? blocks - 1 : blocks);
  }
};

/// One of its lanes contributes nothing to its warp's sums.
template <int threads, class Shared>
struct LossyBlock : HostBlock<threads, Shared> {
  using Base = HostBlock<threads, Shared>;
  using Base::Base;
  template <class T, int n, class... Active>
  void warpSum(typename Base::template PerThread<Lanes<T, n>>& x, const Active&... active) {
    for (int t = 31; t < threads; t += kWarp)
      x[t] = {};
    Base::warpSum(x, active...);
  }
  template <int n, class... Active>
  void warpShare(typename Base::template PerThread<Lanes<float, n>>& x,
                 typename Base::template PerThread<float>& own, const Active&... active) {
    for (int t = 31; t < threads; t += kWarp)
      x[t] = {};
    Base::warpShare(x, own, active...);
  }
};
struct LosesLanes {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    const auto shared = std::make_unique<typename Kernel::Shared>();
    for (std::int64_t i = 0; i < blocks; ++i) {
      LossyBlock<Kernel::kThreads, typename Kernel::Shared> block(i, *shared);
      kernel(block);
    }
  }
};

constexpr std::int64_t kMemory = std::int64_t{1} << 36;

std::string variable(const char* name) {
  const char* set = std::getenv(name);
  return set ? set : "";
}

bool wrong(const char* how) {
  return variable("INNERGS_WRONG") == how;
}

void start() {
  if (wrong("asleep")) std::abort();
  if (wrong("gated")) {
    const std::string gate = variable("INNERGS_WRONG_GATE");
    std::ofstream(gate + ".entered") << "entered";
    while (!std::filesystem::exists(gate + ".open"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  if (wrong("busy")) throw Error(ErrorCode::Internal, "The device is busy.");
}

class WrongPlugin final : public ExecutorPlugin {
public:
  DeviceList devices() override {
    DeviceList list;
    for (const char* name : {"Loses blocks", "Loses lanes", "Has no memory"})
      list.devices.push_back({name, "0.0", kMemory, 0, {}});
    if (!wrong("alone")) list.devices.push_back({"Right", "0.0", kMemory, 0, {}});
    return list;
  }
  std::int64_t freeMemory(int) override {
    start();
    return kMemory;
  }

protected:
  std::unique_ptr<Executor> executor(int device) override {
    start();
    if (const std::string log = variable("INNERGS_WRONG_LOG"); !log.empty())
      std::ofstream(log, std::ios::app) << device << "\n";
    constexpr std::size_t memory = kMemory;
    if (device == 0) return std::make_unique<HostExecutor<LosesBlocks>>(memory);
    if (device == 1) return std::make_unique<HostExecutor<LosesLanes>>(memory);
    return makeHostExecutor(device == 2 ? std::size_t{1000} : memory);
  }
};

} // namespace

INNERGS_DEVICE_PLUGIN(WrongPlugin)
