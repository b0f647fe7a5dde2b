// Tests the self-check: what it must detect, and what it must tolerate.
#include "Core/Device/DeviceCheck.h"
#include "Cuda/Plugin.h"
#include "RoundingExecutor.h"

#include <cstdlib>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::cuda;

namespace {

/// Disables one kind of kernel.
template <class Left>
struct LeavesOut {
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    if constexpr (!std::is_same_v<Kernel, Left>) runAll(kernel, blocks);
  }
};

template <class Runner>
class Plugin final : public ExecutorPlugin {
public:
  DeviceList devices() override { return {{{"test", "0.0", 1 << 30, 0, {}}}, {}}; }
  std::int64_t freeMemory(int) override { return 1 << 30; }

protected:
  std::unique_ptr<Executor> executor(int) override {
    return std::make_unique<HostExecutor<Runner>>(std::size_t{1} << 40);
  }
};

template <class Runner>
std::string verdictOn() {
  Plugin<Runner> plugin;
  return deviceDisagreement(plugin, 0);
}

TEST(DeviceCheck, SeesWhatRelocationAndDensificationLeaveOut) {
  EXPECT_EQ(verdictOn<LeavesOut<void>>(), "");
  EXPECT_NE(verdictOn<LeavesOut<Relocate>>(), "");
  EXPECT_NE(verdictOn<LeavesOut<MarkParents>>(), "");
  EXPECT_NE(verdictOn<LeavesOut<TakeRecords>>(), "");
  EXPECT_NE(verdictOn<LeavesOut<Densify>>(), "");
}

TEST(DeviceCheck, AcceptsADeviceThatRoundsOtherwise) {
  const char* asked = std::getenv("INNERGS_SEEDS"); // more of them, on request
  const int seeds = asked ? std::atoi(asked) : 4;
  int refused = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Rounding::random = 77u * seed;
    const std::string verdict = verdictOn<Rounding>();
    if (!verdict.empty()) ++refused;
    EXPECT_EQ(verdict, "") << "seed " << seed;
  }
  EXPECT_EQ(refused, 0);
}

} // namespace
