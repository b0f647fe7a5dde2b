#include "JobInputs.h"

#include "Core/DevicePlugin.h"
#include "Core/Devices.h"

#include <chrono>
#include <cstdlib>

using namespace innergs;
using namespace innergs::testing;

namespace {

void setVariable(const char* name, const char* value) {
#ifdef _WIN32
  _putenv_s(name, value);
#else
  setenv(name, value, 1);
#endif
}

/// With a plugin of which three devices go wrong and one does not.
class SelfCheck : public ::testing::Test {
protected:
  static void SetUpTestSuite() { setVariable("INNERGS_PLUGIN_PATH", INNERGS_WRONG_PLUGIN); }
  void SetUp() override { setVariable("INNERGS_WRONG", ""); }
};

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

} // namespace

TEST_F(SelfCheck, IsQuickAndMadeOnce) {
  const auto seconds = [] {
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(otherDevices().devices.size(), 4u);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };
  const double first = seconds(), again = seconds();
  RecordProperty("seconds_for_four_devices", std::to_string(first));
  EXPECT_LT(first, 3) << "50 ms each, where nothing else runs";
  EXPECT_LT(again, 0.1 * first + 1e-3);
}

TEST_F(SelfCheck, RefusesDevicesThatComputeWronglyAndSaysSo) {
  const DeviceList list = otherDevices();
  ASSERT_EQ(list.devices.size(), 4u);
  EXPECT_TRUE(has(list.devices[0].refused, "Loses blocks (cuda:0) is not used: in its self-check, its loss"))
      << list.devices[0].refused;
  EXPECT_TRUE(has(list.devices[1].refused, "Loses lanes (cuda:1) is not used: in its self-check, its loss"))
      << list.devices[1].refused;
  EXPECT_TRUE(
      has(list.devices[2].refused, "Has no memory (cuda:2) is not used: in its self-check, it failed: "))
      << list.devices[2].refused;
  EXPECT_EQ(list.devices[3].refused, "");

  const DeviceChoice choice("auto");
  EXPECT_EQ(choice.use.id, "cuda:3");
  EXPECT_TRUE(has(choice.use.reason, "On Right (cuda:3), the GPU found. Loses blocks (cuda:0) is not used"))
      << choice.use.reason;
  EXPECT_EQ(DeviceChoice("cuda").use.id, "cuda:3");
  EXPECT_EQ(DeviceChoice("cuda:3").use.reason, "On Right (cuda:3), as asked.");
  try {
    DeviceChoice insists("cuda:1");
    FAIL() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(error.what(), list.devices[1].refused + " Use the CPU.");
  }
}

TEST_F(SelfCheck, LeavesTheJobOnTheCpuWhereNoDeviceIsRight) {
  setVariable("INNERGS_WRONG", "alone");
  Settings settings = quickSettings(4);
  const auto cpu = reconstruct(isotropicInput(), settings);
  settings.device = "auto";
  std::string note;
  ReconstructionJob job(isotropicInput(), settings);
  job.onProgress([&](const Progress& p) { note += p.note; });
  const auto result = job.run();
  EXPECT_EQ(result.device.id, "cpu");
  EXPECT_TRUE(has(result.device.reason, "On the CPU. Loses blocks (cuda:0) is not used: in its self-check"));
  EXPECT_TRUE(has(result.device.reason, "Loses lanes (cuda:1) is not used"));
  EXPECT_TRUE(has(result.device.reason, "Has no memory (cuda:2) is not used"));
  EXPECT_EQ(note, result.device.reason);
  EXPECT_TRUE(sameField(result.checkpoint->field, cpu.checkpoint->field));
}
