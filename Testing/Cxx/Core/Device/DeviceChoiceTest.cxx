#include "FakeDevice.h"
#include "TextContains.h"

using namespace innergs;
using namespace innergs::testing;
using innergs::test::has;

namespace {
class Choice : public FakeDevice {};

std::string refusal(const std::string& asked, const std::string& set = {},
                    Selection selection = Selection::Exact) {
  try {
    DeviceChoice choice(asked, set, selection);
    return "accepted as " + choice.use.id;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    return error.what();
  }
}

} // namespace

TEST_F(Choice, ListsWhatThePluginOffers) {
  const DeviceList list = otherDevices();
  ASSERT_EQ(list.devices.size(), 2u);
  EXPECT_EQ(list.devices[1].name, "Fake Two");
  EXPECT_EQ(list.devices[1].computeCapability, "9.0");
  EXPECT_EQ(list.devices[1].freeMemory, 4'000'000'000);
  fails("none");
  EXPECT_TRUE(otherDevices().devices.empty());
  EXPECT_EQ(otherDevices().problem, "No NVIDIA driver is installed.");
  fails("throws");
  EXPECT_TRUE(otherDevices().devices.empty());
  EXPECT_TRUE(has(otherDevices().problem, "nothing answers"));
}

TEST_F(Choice, AutoTakesTheDeviceWithTheMostMemory) {
  const DeviceChoice choice("auto");
  EXPECT_EQ(choice.use.asked, "auto");
  EXPECT_EQ(choice.use.id, "cuda:1");
  EXPECT_EQ(choice.use.name, "Fake Two");
  EXPECT_TRUE(has(choice.use.reason, "Fake Two (cuda:1)"));
  EXPECT_FALSE(choice.onCpu());
  EXPECT_EQ(DeviceChoice("cuda").use.id, "cuda:1");
  EXPECT_EQ(DeviceChoice("cuda:0").use.name, "Fake One");
  EXPECT_TRUE(has(DeviceChoice("cuda:0").use.reason, "as asked"));
}

TEST_F(Choice, AutoIsTheCpuWhereThereIsNoDeviceOrTheCpuAloneCan) {
  EXPECT_EQ(DeviceChoice("auto", "scalar").use.id, "cpu");
  EXPECT_TRUE(has(DeviceChoice("auto", "scalar").use.reason, "scalar"));
  EXPECT_EQ(DeviceChoice("auto", "", Selection::Method2).use.id, "cpu");
  EXPECT_TRUE(has(DeviceChoice("auto", "", Selection::Method2).use.reason, "method2"));
  fails("none");
  const DeviceChoice choice("auto");
  EXPECT_TRUE(choice.onCpu());
  EXPECT_TRUE(has(choice.use.reason, "No NVIDIA driver is installed."));
  EXPECT_TRUE(DeviceChoice("cpu").onCpu());
  EXPECT_EQ(DeviceChoice("cpu").use.reason, "On the CPU, as asked.");
}

TEST_F(Choice, OfWhatIsNotThereIsRefused) {
  EXPECT_TRUE(has(refusal("cuda:2"), "cuda:1"));
  EXPECT_TRUE(has(refusal("cuda", "scalar"), "scalar"));
  EXPECT_TRUE(has(refusal("cuda", "", Selection::Method1), "method1"));
  for (const char* name : {"", "gpu", "CUDA", "cuda:", "cuda:-1", "cuda:x", "cuda:99999999999", "cuda: 1"}) {
    EXPECT_TRUE(has(refusal(name), "choose auto, cpu, cuda or cuda:N")) << name;
    Settings settings;
    settings.device = name;
    EXPECT_THROW(checkSettings(settings), Error) << name;
  }
  fails("none");
  EXPECT_TRUE(has(refusal("cuda"), "No NVIDIA driver is installed."));
  EXPECT_TRUE(has(refusal("cuda:0"), "No NVIDIA driver is installed."));
}

TEST_F(Choice, AutoLeavesSmallFitsToTheCpu) {
  FitRequest request;
  Observation observation;
  observation.samples = 1'000'000;
  request.observations = std::make_shared<const std::vector<Observation>>(1, observation);
  const auto chosen = [&](const char* asked, int iterations) {
    DeviceChoice choice(asked);
    request.iterations = iterations;
    choice.considerSize(request);
    return choice.use;
  };
  EXPECT_EQ(chosen("auto", 100).id, "cuda:1");
  EXPECT_EQ(chosen("auto", 0).id, "cuda:1") << "of unknown length";
  EXPECT_EQ(chosen("cuda", 10).id, "cuda:1") << "as asked";
  EXPECT_EQ(chosen("auto", 20).id, "cpu");
  EXPECT_EQ(chosen("auto", 20).reason,
            "On the CPU. The fit is small: about 0.3 s of work, not worth starting a GPU.");
}
