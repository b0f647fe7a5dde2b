#include "JobInputs.h"

#include "Core/DevicePlugin.h"
#include "Core/Devices.h"

#include <chrono>
#include <cstdlib>
#include <thread>

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

GaussianField somethingToRender() {
  GaussianField field;
  field.gaussians.resize(1);
  field.gaussians[0].quaternion[0] = 1;
  return field;
}

} // namespace

// In this order where all run in one process: nothing is known of a device at first.

TEST_F(SelfCheck, IsNotMadeForASmallFitThatMayRunAnywhere) {
  setVariable("INNERGS_WRONG", "asleep");
  Settings settings = quickSettings(4);
  settings.device = "auto";
  const auto result = reconstruct(isotropicInput(), settings);
  EXPECT_EQ(result.device.id, "cpu");
  EXPECT_TRUE(has(result.device.reason, "The fit is small")) << result.device.reason;
}

TEST_F(SelfCheck, ThatCannotBeMadeNowIsMadeLater) {
  setVariable("INNERGS_WRONG", "busy");
  for (const DeviceInfo& device : otherDevices().devices)
    EXPECT_TRUE(has(device.refused, "in its self-check, it failed: The device is busy.")) << device.refused;
  Settings settings = quickSettings(4);
  settings.device = "cuda:3";
  const auto busy = reconstruct(isotropicInput(), settings);
  EXPECT_EQ(busy.device.id, "cpu");
  ASSERT_EQ(busy.warnings.size(), 1u);
  EXPECT_TRUE(has(busy.warnings[0], "On the CPU. Right (cuda:3) is not used: in its self-check, it failed"));
  setVariable("INNERGS_WRONG", "");
  EXPECT_EQ(DeviceChoice("cuda:0").use.id, "cuda:0") << "nothing is known against it";
}

TEST_F(SelfCheck, CanBeStopped) {
  setVariable("INNERGS_WRONG", "slow");
  Settings settings = quickSettings(4);
  settings.device = "cuda:3";
  std::stop_source stop;
  std::chrono::steady_clock::time_point asked;
  std::jthread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    asked = std::chrono::steady_clock::now();
    stop.request_stop();
  });
  ReconstructionJob job(isotropicInput(), settings);
  const auto stopped = job.run(stop.get_token());
  const auto ended = std::chrono::steady_clock::now();
  stopper.join();
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_EQ(stopped.iterations, 0);
  EXPECT_LT(std::chrono::duration<double>(ended - asked).count(), 0.2);
  setVariable("INNERGS_WRONG", "");
  const auto result = reconstruct(isotropicInput(), settings); // waits for the check that still runs
  EXPECT_EQ(result.device.id, "cuda:3") << result.device.reason;
  EXPECT_TRUE(result.warnings.empty());
}

TEST_F(SelfCheck, RefusesADeviceThatWasAskedForWhenItIsUsed) {
  Settings settings = quickSettings(4);
  settings.device = "cuda:1";
  try {
    reconstruct(isotropicInput(), settings);
    FAIL() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_TRUE(has(error.what(), "Loses lanes (cuda:1) is not used: in its self-check, its loss"))
        << error.what();
  }
}

TEST_F(SelfCheck, IsQuickAndMadeOnce) {
  const auto seconds = [] {
    const auto begun = std::chrono::steady_clock::now();
    EXPECT_EQ(otherDevices().devices.size(), 4u);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };
  const double first = seconds(), again = seconds();
  RecordProperty("seconds_for_four_devices", std::to_string(first));
  EXPECT_LT(first, 3) << "50 ms each, where nothing else runs";
  EXPECT_LT(again, 0.5 * first + 0.01) << "only the device without memory is tried again";
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

  const GaussianField field = somethingToRender();
  DeviceChoice choice("auto"), any("cuda");
  EXPECT_TRUE(choice.makeField(field));
  EXPECT_EQ(choice.use.id, "cuda:3");
  EXPECT_TRUE(has(choice.use.reason, "On Right (cuda:3), the GPU found. Loses blocks (cuda:0) is not used"))
      << choice.use.reason;
  EXPECT_TRUE(any.makeField(field));
  EXPECT_EQ(any.use.id, "cuda:3");
  EXPECT_EQ(DeviceChoice("cuda:3").use.reason, "On Right (cuda:3), as asked.");
  try {
    DeviceChoice insists("cuda:1");
    FAIL() << "taken";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    EXPECT_EQ(error.what(), list.devices[1].refused + " Use the CPU.");
  }
}

TEST_F(SelfCheck, LeadsToTheCpuWhereNoDeviceIsRight) {
  setVariable("INNERGS_WRONG", "alone");
  DeviceChoice choice("auto");
  EXPECT_FALSE(choice.makeField(somethingToRender()));
  EXPECT_TRUE(choice.onCpu());
  EXPECT_TRUE(has(choice.use.reason, "On the CPU. Loses blocks (cuda:0) is not used: in its self-check"));
  EXPECT_TRUE(has(choice.use.reason, "Loses lanes (cuda:1) is not used"));
  EXPECT_TRUE(has(choice.use.reason, "Has no memory (cuda:2) is not used"));
  Settings settings = quickSettings(4);
  const auto cpu = reconstruct(isotropicInput(), settings);
  settings.device = "cuda:2"; // too little memory is no reason to fail
  std::string note;
  ReconstructionJob job(isotropicInput(), settings);
  job.onProgress([&](const Progress& p) { note += p.note; });
  const auto result = job.run();
  EXPECT_EQ(result.device.id, "cpu");
  EXPECT_TRUE(has(result.device.reason, "On the CPU. Has no memory (cuda:2) is not used"));
  EXPECT_EQ(note, result.device.reason);
  EXPECT_TRUE(sameField(result.checkpoint->field, cpu.checkpoint->field));
}
