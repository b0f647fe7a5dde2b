// Tests the self-check: what it must detect, and what it must tolerate.
#include "Core/Device/DeviceCheck.h"
#include "Cuda/Plugin.h"
#include "Executors.h"
#include "RoundingExecutor.h"

#include <cstdlib>
#include <gtest/gtest.h>
#include <typeindex>

using namespace innergs;
using namespace innergs::cuda;

namespace {

/// Disables one kind of kernel.
struct LeavesOut {
  inline static std::type_index left = typeid(void);
  template <class Kernel>
  static void run(const Kernel& kernel, std::int64_t blocks) {
    if (left != typeid(Kernel)) runOnHost(kernel, blocks);
  }
};

class Plugin final : public ExecutorPlugin {
public:
  explicit Plugin(std::unique_ptr<Executor> (*executor)()) : executor_(executor) {}
  DeviceList devices() override { return {{{"test", "0.0", 1 << 30, 0, {}}}, {}}; }
  std::int64_t freeMemory(int) override { return 1 << 30; }

protected:
  std::unique_ptr<Executor> executor(int) override { return executor_(); }

private:
  std::unique_ptr<Executor> (*executor_)();
};

std::string verdictOn(std::unique_ptr<Executor> (*executor)()) {
  Plugin plugin(executor);
  return deviceDisagreement(plugin, 0);
}

template <class Kernel>
std::string verdictWithout() {
  LeavesOut::left = typeid(Kernel);
  return verdictOn([]() -> std::unique_ptr<Executor> {
    return std::make_unique<HostExecutor<LeavesOut>>(std::size_t{1} << 40);
  });
}

TEST(DeviceCheck, SeesWhatRelocationAndDensificationLeaveOut) {
  EXPECT_EQ(verdictWithout<void>(), "");
  EXPECT_NE(verdictWithout<Relocate>(), "");
  EXPECT_NE(verdictWithout<MarkParents>(), "");
  EXPECT_NE(verdictWithout<TakeRecords>(), "");
  EXPECT_NE(verdictWithout<Densify>(), "");
}

TEST(DeviceCheck, AcceptsADeviceThatRoundsOtherwise) {
  const char* asked = std::getenv("INNERGS_SEEDS"); // more of them, on request
  const int seeds = asked ? std::atoi(asked) : 4;
  int refused = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    Rounding::random = 77u * seed;
    const std::string verdict = verdictOn(innergs::testing::makeRoundingExecutor);
    if (!verdict.empty()) ++refused;
    EXPECT_EQ(verdict, "") << "seed " << seed;
  }
  EXPECT_EQ(refused, 0);
}

} // namespace
