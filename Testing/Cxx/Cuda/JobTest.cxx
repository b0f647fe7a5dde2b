#include "Features/BoxPhantom.h"
#include "JobInputs.h"
#include "Motion/MovingPhantom.h"

#include "Core/Base/Error.h"
#include "Core/Device/Devices.h"
#include "Core/Device/FeatureDeviceChoice.h"
#include "Core/Features/FeatureQuery.h"
#include "Core/Features/FeatureTraining.h"
#include "Core/Image/Metrics.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/FrameRenderer.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"

#include <cstdlib>

using namespace innergs;
using namespace innergs::testing;

namespace {

struct Case {
  const char* name;
  ReconstructionInput (*input)();
  Blending blending;
};
void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}
const Case kCases[] = {{"Isotropic", isotropicInput, Blending::Normalised},
                       {"ThickSlices", anisotropicInput, Blending::Normalised},
                       {"TwoStacks", orthogonalInput, Blending::Normalised},
                       {"Additive", isotropicInput, Blending::Additive},
                       {"Alpha", isotropicInput, Blending::Alpha}};

/// INNERGS_TEST_PLUGIN names the folder of another plugin, such as that of a GPU.
const char* otherPlugin() {
  return std::getenv("INNERGS_TEST_PLUGIN");
}

void usePlugin() {
  const char* folder = otherPlugin() ? otherPlugin() : INNERGS_HOST_PLUGIN;
#ifdef _WIN32
  _putenv_s("INNERGS_PLUGIN_PATH", folder);
#else
  setenv("INNERGS_PLUGIN_PATH", folder, 1);
#endif
}

void expectDevice(const DeviceUse& use) {
  EXPECT_EQ(use.id, "cuda:0") << use.reason;
  if (!otherPlugin()) {
    EXPECT_EQ(use.name, "Host executor");
  }
}

/// Whole reconstructions through the plugin loader, with the kernels on the host executor unless told
/// otherwise.
class Jobs : public ::testing::TestWithParam<Case> {
protected:
  static void SetUpTestSuite() { usePlugin(); }
};

} // namespace

TEST(FeaturesOnADevice, AreLearnedThroughThePluginLoader) {
  usePlugin();
  const BoxPhantom phantom(20);
  const Labelmap labels = phantom.every(4);
  FeatureTraining training;
  training.threads = 1;
  const FeatureModel cpu = trainFeatures(phantom.field, labels, {}, training);
  const auto choice = std::make_shared<FeatureDeviceChoice>("cuda:0");
  training.devices = choice;
  const FeatureModel device = trainFeatures(phantom.field, labels, {}, training);
  EXPECT_EQ(choice->use().id, "cuda:0") << choice->use().reason;
  EXPECT_NE(device.latents, cpu.latents) << "sums in another order";
  const GridGeometry& grid = phantom.labels.geometry;
  const auto expected = classify(phantom.field, cpu, grid).classes,
             found = classify(phantom.field, device, grid).classes;
  int different = 0;
  for (std::size_t v = 0; v < expected.size(); ++v)
    different += found[v] != expected[v];
  EXPECT_LE(different, static_cast<int>(expected.size() / 500));

  const auto automatic = std::make_shared<FeatureDeviceChoice>("auto");
  training.devices = automatic;
  const FeatureModel small = trainFeatures(phantom.field, labels, {}, training);
  EXPECT_EQ(automatic->use().id, "cpu") << "too small to be worth starting a device";
  EXPECT_EQ(small.latents, cpu.latents);
  EXPECT_THROW(FeatureDeviceChoice("cuda:7"), Error);
}

TEST_P(Jobs, GiveTheVolumeOfTheCpu) {
  Settings settings = quickSettings(16);
  settings.blending = GetParam().blending;
  settings.threads = 1;
  settings.consistency = false; // compares the Gaussians alone
  const auto cpu = reconstruct(GetParam().input(), settings);
  settings.device = "cuda:0";
  const auto device = reconstruct(GetParam().input(), settings);
  expectDevice(device.device);
  EXPECT_TRUE(device.warnings == cpu.warnings);
  EXPECT_EQ(device.iterations, cpu.iterations);
  EXPECT_NEAR(device.trainingPsnr, cpu.trainingPsnr, 0.05);
  ASSERT_EQ(device.volume.voxels.size(), cpu.volume.voxels.size());
  EXPECT_GT(psnr(device.volume, cpu.volume), cpu.trainingPsnr + 6);
}

/// Planes, volumes and points of a fitted model, to 1e-4 of its range.
TEST_P(Jobs, AnswerQueriesAsTheCpu) {
  Settings settings = quickSettings(6);
  settings.blending = GetParam().blending;
  const auto field = std::make_shared<GaussianField>(reconstruct(GetParam().input(), settings).model->field);
  const double tolerance = 1e-4 * std::abs(field->intensityScale);
  const auto expectNear = [&](std::span<const float> found, std::span<const float> expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t i = 0; i < found.size(); ++i)
      ASSERT_NEAR(found[i], expected[i], tolerance) << i;
  };
  PlaneSampler cpu(field, 1), device(field, 1, "", DeviceChoice("cuda:0").makeField(*field));
  std::vector<float> a(50 * 44), b(a.size());
  for (const double angle : {0.4, 1.1}) { // like a slice that is dragged
    const Affine3 plane =
        grid(50, 44, 1, {0.8, 0.8, 1}, {-38, 5, 12}, obliqueDirection(angle)).indexToWorld();
    cpu.sample(plane, 50, 44, a);
    device.sample(plane, 50, 44, b);
    expectNear(b, a);
  }
  RenderOptions options;
  options.threads = 1;
  RenderOptions onDevice = options;
  onDevice.device = DeviceChoice("cuda:0").makeField(*field);
  ASSERT_TRUE(onDevice.device);
  const GridGeometry volume = grid(20, 18, 9, {1.1, 1.2, 2}, {-36, 5, 3}, obliqueDirection(0.7, true));
  expectNear(render(*field, volume, onDevice).voxels, render(*field, volume, options).voxels);
  std::vector<Vec3> points;
  for (int i = 0; i < 300; ++i)
    points.push_back({-36 + i * 0.1, 8 + i * 0.08, 2 + i * 0.07});
  expectNear(renderPoints(*field, points, onDevice), renderPoints(*field, points, options));
}

/// Rounding, which Adam's steps amplify, must stay far below the error of the fit itself.
TEST(DynamicJobs, GiveTheFramesOfTheCpu) {
  usePlugin();
  const TimeSeries series = movingPhantom(evenTimes(5));
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    SCOPED_TRACE(dynamicKindName(kind));
    Settings settings;
    settings.kind = kind;
    settings.rounds = 12;
    settings.threads = 1;
    settings.device = "cpu";
    const DynamicResult cpu = DynamicJob(series, settings).run();
    settings.device = "cuda:0";
    const DynamicResult device = DynamicJob(series, settings).run();
    expectDevice(device.device);
    EXPECT_TRUE(device.notes.empty());
    EXPECT_EQ(device.field->size(), cpu.field->size());
    EXPECT_NEAR(device.trainingPsnr, cpu.trainingPsnr, 0.1);
    FrameRenderer found(*device.field, series.geometry, {}, "cuda:0"),
        expected(*cpu.field, series.geometry, {}, "cpu");
    for (const double time : {0.0, 0.75, 1.6})
      EXPECT_GT(pooledPsnr(found.at(time), expected.at(time), {}, 200), cpu.trainingPsnr + 6) << time;
  }
}

INSTANTIATE_TEST_SUITE_P(OnTheHostExecutor, Jobs, ::testing::ValuesIn(kCases),
                         [](const auto& info) { return info.param.name; });
