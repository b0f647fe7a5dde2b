#include "Core/Device/FeatureDeviceChoice.h"

#include "Core/Base/Error.h"
#include "Core/Features/FeatureTraining.h"
#include "FakeDevice.h"
#include "Features/BoxPhantom.h"
#include "TextContains.h"

using namespace innergs;
using namespace innergs::testing;
using innergs::test::has;

namespace {

class FeatureDeviceChoices : public FakeDevice {};

} // namespace

TEST_F(FeatureDeviceChoices, GoOnWithTheCpuAndSayWhy) {
  const BoxPhantom phantom;
  FeatureTraining training;
  training.iterations = 3;
  const FeatureModel cpu = trainFeatures(phantom.field, phantom.labels, {}, training);
  const auto asked = std::make_shared<FeatureDeviceChoice>("cuda");
  EXPECT_EQ(asked->use().id, "cuda:1");
  training.devices = asked;
  const FeatureModel model = trainFeatures(phantom.field, phantom.labels, {}, training);
  EXPECT_EQ(asked->use().id, "cpu");
  EXPECT_TRUE(has(asked->use().reason, "it learns no features.")) << asked->use().reason;
  EXPECT_EQ(model.latents, cpu.latents);

  const auto onCpu = std::make_shared<FeatureDeviceChoice>("cpu");
  training.devices = onCpu;
  EXPECT_EQ(trainFeatures(phantom.field, phantom.labels, {}, training).latents, cpu.latents);
  EXPECT_TRUE(has(onCpu->use().reason, "as asked")) << onCpu->use().reason;
  EXPECT_THROW(FeatureDeviceChoice("cuda:9"), Error);
}
