#include "FakeDevice.h"
#include "TextContains.h"
#include "ThrownError.h"

#include "Core/Job/TimeEstimate.h"

using namespace innergs;
using namespace innergs::testing;
using innergs::test::has;

namespace {

class DeviceJob : public FakeDevice {
protected:
  /// A run that stops in its n-th iteration (−1: never) and collects what the progress says about the device.
  ReconstructionResult runUntil(int iteration, const ReconstructionInput& input, const Settings& settings,
                                bool previews = false) {
    notes.clear();
    shown = 0;
    double fraction = 0;
    std::stop_source stop;
    ReconstructionJob job(input, settings);
    job.onProgress([&](const Progress& p) {
      if (!p.note.empty() && p.phase != Phase::Predicting) notes.push_back(p.note);
      EXPECT_GE(p.fraction, fraction);
      fraction = p.fraction;
      if (p.phase == Phase::Fitting && p.iteration == iteration) stop.request_stop();
    });
    if (previews) job.onPreview([&](const Volume&) { ++shown; });
    return job.run(stop.get_token());
  }

  std::vector<std::string> notes;
  int shown = 0;
};

} // namespace

TEST_F(DeviceJob, RunsOnTheDeviceAndSaysSo) {
  for (const auto& input : {isotropicInput(), anisotropicInput(), orthogonalInput()}) {
    const auto cpu = runUntil(-1, input, reference());
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], cpu.device.reason);
    EXPECT_EQ(cpu.device.id, "cpu");
    const auto device = runUntil(-1, input, on("cuda"));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(has(notes[0], "On Fake Two (cuda:1)")) << notes[0];
    EXPECT_EQ(device.device.asked, "cuda");
    EXPECT_EQ(device.device.id, "cuda:1");
    EXPECT_EQ(device.device.name, "Fake Two");
    EXPECT_EQ(device.device.reason, notes[0]);
    EXPECT_TRUE(device.warnings.empty());
    EXPECT_TRUE(sameField(cpu.model->field, device.model->field));
    EXPECT_EQ(cpu.trainingPsnr, device.trainingPsnr);
    EXPECT_EQ(cpu.iterations, device.iterations);
  }
}

TEST_F(DeviceJob, IsEstimatedByTheLastFitOnTheDevice) {
  const ReconstructionInput input = isotropicInput();
  const Settings fit = on("cuda:0", quickSettings(30));
  EXPECT_EQ(estimateSeconds(input, fit), 0) << "nothing has run there yet";
  const auto result = runUntil(-1, input, fit);
  ASSERT_EQ(result.device.id, "cuda:0");
  EXPECT_GT(estimateSeconds(input, fit), 0);
  Settings longer = fit;
  longer.iterations = 3 * *longer.iterations;
  const double once = estimateSeconds(input, fit), thrice = estimateSeconds(input, longer);
  EXPECT_NEAR(thrice - once, 2 * result.fitSeconds, 1e-6 + 0.01 * result.fitSeconds);
  EXPECT_EQ(result.iterationsRun, result.iterations);

  // A resumed model: only the iterations of this run count, and few are not representative.
  const auto stopped = runUntil(*result.settings.iterations - 5, input, fit);
  ASSERT_TRUE(stopped.cancelled);
  ReconstructionInput goingOn = input;
  goingOn.resume = stopped.model;
  const auto resumed = runUntil(-1, goingOn, fit);
  EXPECT_EQ(resumed.iterations, result.iterations);
  EXPECT_EQ(resumed.iterationsRun, resumed.iterations - stopped.iterations);
  EXPECT_EQ(estimateSeconds(input, fit), once);
}

TEST_F(DeviceJob, RendersResultHeldOutSlicesAndPreviewsOnTheDevice) {
  ReconstructionInput input = isotropicInput();
  input.heldOutFraction = 0.2;
  Settings settings = on("cuda:0");
  settings.consistency = false; // a residual grid would undo the mark
  const auto plain = runUntil(-1, input, settings);
  fails("mark");
  const auto marked = runUntil(-1, input, settings);
  ASSERT_EQ(plain.volume.voxels.size(), marked.volume.voxels.size());
  const double range = plain.model->field.intensityScale;
  const std::size_t middle = plain.volume.voxels.size() / 2;
  EXPECT_GT(marked.volume.voxels[middle] - plain.volume.voxels[middle], 0.9 * range) << "up to the range";
  EXPECT_LT(marked.heldOutPsnr, 3);
  EXPECT_GT(plain.heldOutPsnr, 10);
  fails("render"); // the CPU renders
  const auto fallen = runUntil(-1, input, settings);
  EXPECT_NEAR(fallen.heldOutPsnr, plain.heldOutPsnr, 1e-3);
  for (std::size_t v = 0; v < plain.volume.voxels.size(); ++v)
    ASSERT_NEAR(plain.volume.voxels[v], fallen.volume.voxels[v], 1e-3 * range) << v;
}

TEST_F(DeviceJob, FallsBackToTheCpuAtTheStart) {
  Settings gaussiansAlone = quickSettings();
  gaussiansAlone.consistency = false;
  const auto cpu = runUntil(-1, isotropicInput(), reference(gaussiansAlone));
  struct Case {
    const char *fault, *device, *says;
  };
  for (const auto& [how, device, says] :
       {Case{"small", "cuda", "needs about"}, Case{"small", "cuda:1", "needs about"},
        Case{"make", "cuda", "The device has no memory left."}}) {
    SCOPED_TRACE(how);
    fails(how);
    const auto result = runUntil(-1, isotropicInput(), on(device, gaussiansAlone));
    EXPECT_EQ(result.device.asked, device);
    EXPECT_EQ(result.device.id, "cpu");
    EXPECT_TRUE(has(result.device.reason, says)) << result.device.reason;
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_EQ(result.warnings[0], result.device.reason);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], result.device.reason);
    EXPECT_NEAR(result.trainingPsnr, cpu.trainingPsnr, 0.05);
  }
}

TEST_F(DeviceJob, GoesOnOnTheCpuMidway) {
  Settings settings = quickSettings(12);
  settings.ensembleSize = 2;
  settings.prediction = PredictionKind::None; // the device fails in this fit, not in the prediction's
  const auto cpu = runUntil(-1, anisotropicInput(), reference(settings));
  for (const char* how :
       {"upload", "iteration:1", "iteration:7", "iteration:20", "lost:7", "lost:20", "download"}) {
    SCOPED_TRACE(how);
    fails(how);
    const auto result = runUntil(-1, anisotropicInput(), on("cuda", settings));
    EXPECT_FALSE(result.cancelled);
    EXPECT_EQ(result.device.id, "cpu");
    EXPECT_TRUE(has(result.device.reason, "Fake Two (cuda:1) failed after iteration"))
        << result.device.reason;
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_EQ(result.warnings[0], result.device.reason);
    ASSERT_EQ(notes.size(), 2u) << "where it began and where it went";
    EXPECT_EQ(result.iterations, cpu.iterations);
    EXPECT_EQ(result.model->field.size(), cpu.model->field.size());
    EXPECT_NEAR(result.trainingPsnr, cpu.trainingPsnr, 0.05);
  }
}

TEST_F(DeviceJob, OnADeviceThatIsNotThereIsRefusedBeforeAnyWork) {
  fails("none");
  bool worked = false;
  ReconstructionJob job(isotropicInput(), on("cuda"));
  job.onProgress([&](const Progress&) { worked = true; });
  const Error error = test::errorOf([&] { job.run(); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_TRUE(has(error.what(), "No NVIDIA driver is installed.")) << error.what();
  EXPECT_FALSE(worked);
  const auto result = runUntil(-1, isotropicInput(), on("auto"));
  EXPECT_TRUE(has(result.device.reason, "No NVIDIA driver is installed."));
  EXPECT_TRUE(result.warnings.empty()) << "nothing went wrong";
}

TEST_F(DeviceJob, StopsAndGoesOnOnTheOtherDevice) {
  Settings settings = quickSettings(12);
  const auto whole = runUntil(-1, isotropicInput(), reference(settings));
  for (const bool deviceFirst : {true, false}) {
    const Settings first = deviceFirst ? on("cuda", settings) : reference(settings);
    const Settings second = deviceFirst ? reference(settings) : on("cuda", settings);
    const auto stopped = runUntil(5, isotropicInput(), first);
    EXPECT_TRUE(stopped.cancelled);
    EXPECT_EQ(stopped.iterations, 5);
    EXPECT_EQ(stopped.device.id, deviceFirst ? "cuda:1" : "cpu");
    ReconstructionInput rest = isotropicInput();
    rest.resume = stopped.model;
    const auto result = runUntil(-1, rest, second);
    EXPECT_TRUE(result.warnings.empty());
    EXPECT_TRUE(sameField(result.model->field, whole.model->field));
    EXPECT_EQ(result.iterations, whole.iterations);
  }
}

TEST_F(DeviceJob, StoppedWithALostDeviceKeepsWhatItHas) {
  fails("download");
  Settings settings = quickSettings(12);
  const auto stopped = runUntil(5, isotropicInput(), on("cuda", settings));
  EXPECT_TRUE(stopped.cancelled);
  EXPECT_EQ(stopped.iterations, 0) << "the iterations went with the device";
  ASSERT_FALSE(stopped.model->field.gaussians.empty());
  fails("");
  ReconstructionInput rest = isotropicInput();
  rest.resume = stopped.model;
  const auto result = runUntil(-1, rest, on("cuda", settings));
  const auto whole = runUntil(-1, isotropicInput(), reference(settings));
  EXPECT_TRUE(sameField(result.model->field, whole.model->field));
}

TEST_F(DeviceJob, ShowsPreviewsWhileItRunsOnTheDevice) {
  Settings settings = quickSettings(100000);
  settings.gaussians = 100;
  std::stop_source stop;
  ReconstructionJob job(isotropicInput(), on("auto", settings)); // long enough for a device

  Volume seen;
  job.onPreview([&](const Volume& volume) {
    seen = volume;
    stop.request_stop();
  });
  const auto result = job.run(stop.get_token());
  EXPECT_TRUE(result.cancelled);
  EXPECT_EQ(result.device.id, "cuda:1");
  EXPECT_GT(result.iterations, 0);
  ASSERT_FALSE(seen.voxels.empty());
  const auto [low, high] = std::minmax_element(seen.voxels.begin(), seen.voxels.end());
  EXPECT_GT(*high - *low, 50);
}

TEST_F(DeviceJob, AutoKeepsASmallFitOnTheCpu) {
  const auto cpu = runUntil(-1, isotropicInput(), on("cpu"));
  const auto result = runUntil(-1, isotropicInput(), on("auto"));
  EXPECT_EQ(result.device.id, "cpu");
  EXPECT_TRUE(has(result.device.reason, "On the CPU. The fit is small: about 0.00")) << result.device.reason;
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], result.device.reason);
  EXPECT_TRUE(result.warnings.empty()) << "nothing went wrong";
  EXPECT_TRUE(sameField(result.model->field, cpu.model->field));
}

TEST_F(DeviceJob, SaysThatItGoesOnInSmallerParts) {
  fails("short");
  const auto result = runUntil(-1, isotropicInput(), on("cuda"));
  EXPECT_EQ(result.device.id, "cuda:1");
  ASSERT_EQ(notes.size(), 2u);
  EXPECT_TRUE(has(notes[1], "in 7 parts.")) << notes[1];
  EXPECT_EQ(notes[1], result.device.reason);
  EXPECT_TRUE(result.warnings.empty());
}
