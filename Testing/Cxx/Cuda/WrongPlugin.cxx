// A device plugin whose devices run the kernels on the host, all but the last one wrongly.
// INNERGS_WRONG=alone leaves the right one out.
#include "Cuda/HostBlock.h"
#include "Cuda/HostExecutor.h"
#include "Cuda/Plugin.h"

#include <cstdlib>
#include <string>
#include <type_traits>

namespace {

using namespace innergs;
using namespace innergs::cuda;

template <class Kernel, class Block>
void runBlocks(const Kernel& kernel, std::int64_t blocks) {
  const auto shared = std::make_unique<typename Kernel::Shared>();
  for (std::int64_t i = 0; i < blocks; ++i) {
    Block block(i, *shared);
    kernel(block);
  }
}

template <class Kernel>
using PlainBlock = HostBlock<Kernel::kThreads, typename Kernel::Shared>;

/// The last brick or tile of an image is never rendered.
struct LosesBlocks {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    constexpr bool renders = std::is_same_v<Kernel, Accumulate> || std::is_same_v<Kernel, Composite>;
    runBlocks<Kernel, PlainBlock<Kernel>>(kernel, renders ? blocks - 1 : blocks);
  }
};

/// One of its lanes has nothing to add to the sums of its warp.
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
};
struct LosesLanes {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    runBlocks<Kernel, LossyBlock<Kernel::kThreads, typename Kernel::Shared>>(kernel, blocks);
  }
};

struct Right {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    runBlocks<Kernel, PlainBlock<Kernel>>(kernel, blocks);
  }
};

class WrongPlugin final : public ExecutorPlugin {
public:
  DeviceList devices() override {
    const char* set = std::getenv("INNERGS_WRONG");
    constexpr std::int64_t memory = std::int64_t{1} << 36;
    DeviceList list;
    for (const char* name : {"Loses blocks", "Loses lanes", "Has no memory"})
      list.devices.push_back({name, "0.0", memory, memory, {}});
    if (!set || std::string(set) != "alone") list.devices.push_back({"Right", "0.0", memory, memory / 2, {}});
    return list;
  }

protected:
  std::unique_ptr<Executor> executor(int device) override {
    constexpr std::size_t memory = std::size_t{1} << 36;
    if (device == 0) return std::make_unique<HostExecutor<LosesBlocks>>(memory);
    if (device == 1) return std::make_unique<HostExecutor<LosesLanes>>(memory);
    return std::make_unique<HostExecutor<Right>>(device == 2 ? std::size_t{1000} : memory);
  }
};

} // namespace

INNERGS_DEVICE_PLUGIN(WrongPlugin)
