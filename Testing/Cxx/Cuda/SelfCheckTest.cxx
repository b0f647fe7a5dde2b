#include "JobInputs.h"
#include "TextContains.h"
#include "ThrownError.h"

#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

using namespace innergs;
using namespace innergs::testing;
using innergs::test::has;

namespace {

void setVariable(const char* name, const char* value) {
#ifdef _WIN32
  _putenv_s(name, value);
#else
  setenv(name, value, 1);
#endif
}

/// With a plugin that has three faulty devices and a good one.
class SelfCheck : public ::testing::Test {
protected:
  static void SetUpTestSuite() { setVariable("INNERGS_PLUGIN_PATH", INNERGS_WRONG_PLUGIN); }
  void SetUp() override { setVariable("INNERGS_WRONG", ""); }

  /// A path for a file of this test that does not exist yet.
  static std::string file(const std::string& name) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    const auto folder = std::filesystem::path(::testing::TempDir()) / "innergs-self-check" / test->name();
    std::filesystem::remove_all(folder);
    std::filesystem::create_directories(folder);
    return (folder / name).string();
  }
};

GaussianField somethingToRender() {
  GaussianField field;
  field.gaussians.resize(1);
  field.gaussians[0].quaternion[0] = 1;
  return field;
}

} // namespace

// In this order if all run in one process: at first nothing is known about the devices.

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
  const std::string gate = file("gate");
  setVariable("INNERGS_WRONG_GATE", gate.c_str());
  setVariable("INNERGS_WRONG", "gated");
  Settings settings = quickSettings(4);
  settings.device = "cuda:3";
  std::stop_source stop;
  std::jthread stopper([&] {
    while (!std::filesystem::exists(gate + ".entered"))
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    stop.request_stop();
  });
  ReconstructionJob job(isotropicInput(), settings);
  const auto stopped = job.run(stop.get_token()); // ends although the device is still starting
  stopper.join();
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_EQ(stopped.iterations, 0);
  std::ofstream(gate + ".open") << "open";
  setVariable("INNERGS_WRONG", "");
  const auto result = reconstruct(isotropicInput(), settings); // waits for the running check
  EXPECT_EQ(result.device.id, "cuda:3") << result.device.reason;
  EXPECT_TRUE(result.warnings.empty());
}

TEST_F(SelfCheck, RefusesADeviceThatWasAskedForWhenItIsUsed) {
  Settings settings = quickSettings(4);
  settings.device = "cuda:1";
  const Error error = test::errorOf([&] { reconstruct(isotropicInput(), settings); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_TRUE(has(error.what(), "Loses lanes (cuda:1) is not used: in its self-check, its loss"))
      << error.what();
}

TEST_F(SelfCheck, IsMadeOnceWhereItCouldBeMade) {
  EXPECT_EQ(otherDevices().devices.size(), 4u);
  const std::string log = file("starts");
  setVariable("INNERGS_WRONG_LOG", log.c_str());
  EXPECT_EQ(otherDevices().devices.size(), 4u);
  setVariable("INNERGS_WRONG_LOG", "");
  std::ifstream starts(log);
  std::set<int> started;
  for (int device; starts >> device;)
    started.insert(device);
  EXPECT_EQ(started, std::set<int>{2}) << "only the device without memory is tried again";
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
  EXPECT_TRUE(has(DeviceChoice("cuda:3").use.reason, "Right (cuda:3), as asked"));
  const Error error = test::errorOf([] { DeviceChoice insists("cuda:1"); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(error.what(), list.devices[1].refused + " Use the CPU.");
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
  EXPECT_TRUE(sameField(result.model->field, cpu.model->field));
}
