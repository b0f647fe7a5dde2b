#include "FakeDevice.h"
#include "Motion/MovingPhantom.h"
#include "TextContains.h"
#include "ThrownError.h"

#include "Core/Image/Metrics.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/FrameRenderer.h"

#include <cstring>

using namespace innergs;
using namespace innergs::testing;
using innergs::test::has;

namespace {

/// Dynamic scans with the fake plugin.
class DynamicDevice : public FakeDevice {
protected:
  static Settings shortFit(DynamicKind kind, const std::string& device) {
    Settings settings;
    settings.kind = kind;
    settings.rounds = 8;
    settings.device = device;
    return settings;
  }
  /// Of the phantom; stopped at the first report of a phase, if one is given.
  DynamicResult run(const Settings& settings, std::optional<Phase> stopAt = {}) {
    notes.clear();
    std::stop_source stop;
    DynamicJob job(series, settings);
    job.onProgress([&](const Progress& p) {
      if (!p.note.empty()) notes.push_back(p.note);
      if (p.phase == stopAt) stop.request_stop();
    });
    return job.run(stop.get_token());
  }
  /// dB, of the frames of two models.
  double agreement(const DynamicResult& a, const DynamicResult& b) const {
    std::vector<float> found, expected;
    for (const double time : {0.2, 1.1, 2.0})
      for (auto [frame, of] : {std::pair{&found, &a}, std::pair{&expected, &b}}) {
        const std::vector<float> values = FrameRenderer(*of->field, series.geometry, {}, "cpu").at(time);
        frame->insert(frame->end(), values.begin(), values.end());
      }
    return pooledPsnr(found, expected, {}, 200);
  }

  const TimeSeries series = movingPhantom(evenTimes(5));
  std::vector<std::string> notes;
};

} // namespace

TEST_F(DynamicDevice, RunsOnTheDeviceAndSaysSo) {
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    SCOPED_TRACE(dynamicKindName(kind));
    Settings scalar = shortFit(kind, "cpu"); // as the fake device computes
    scalar.instructionSet = "scalar";
    const DynamicResult cpu = run(scalar);
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_EQ(notes[0], cpu.device.reason);
    EXPECT_EQ(cpu.device.id, "cpu");
    const DynamicResult device = run(shortFit(kind, "cuda"));
    ASSERT_EQ(notes.size(), 1u);
    EXPECT_TRUE(has(notes[0], "On Fake Two (cuda:1), as asked.")) << notes[0];
    EXPECT_EQ(device.device.asked, "cuda");
    EXPECT_EQ(device.device.id, "cuda:1");
    EXPECT_EQ(device.device.name, "Fake Two");
    EXPECT_TRUE(has(device.device.reason, "The fit needs about")) << device.device.reason;
    EXPECT_EQ(device.device.reason.find("The fit needs about"),
              device.device.reason.rfind("The fit needs about"))
        << "said once, of the frames: " << device.device.reason;
    EXPECT_TRUE(device.notes.empty());
    EXPECT_GT(agreement(device, cpu), 50);
    if (kind == DynamicKind::Network) continue; // whose network has no scalar form on the other side
    EXPECT_EQ(device.field->nodes, cpu.field->nodes);
    EXPECT_EQ(device.field->ownPath, cpu.field->ownPath);
    EXPECT_EQ(0, std::memcmp(device.field->canonical.gaussians.data(), cpu.field->canonical.gaussians.data(),
                             sizeof(Gaussian) * cpu.field->canonical.gaussians.size()));
  }
}

TEST_F(DynamicDevice, GoesOnOnTheCpuWhenItFails) {
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    const DynamicResult cpu = run(shortFit(kind, "cpu"));
    struct Case {
      const char *fault, *says;
    };
    for (const auto& [how, says] :
         {Case{"upload", "on the middle frame"}, Case{"iteration:20", "on the middle frame"},
          Case{"lost:30", "on the middle frame"}, Case{"download", "on the middle frame"},
          Case{"gradient:1", "on frame"}, Case{"gradient:30", "on frame"}}) {
      SCOPED_TRACE(std::string(dynamicKindName(kind)) + " " + how);
      fails(how);
      const DynamicResult result = run(shortFit(kind, "cuda"));
      fails("");
      EXPECT_FALSE(result.cancelled);
      EXPECT_EQ(result.device.id, "cpu");
      EXPECT_TRUE(has(result.device.reason, "Fake Two (cuda:1) failed")) << result.device.reason;
      EXPECT_TRUE(has(result.device.reason, says)) << result.device.reason;
      ASSERT_EQ(result.notes.size(), 1u);
      EXPECT_EQ(result.notes[0], result.device.reason);
      ASSERT_EQ(notes.size(), 2u) << "where it began and where it went";
      EXPECT_EQ(notes[1], result.device.reason);
      EXPECT_EQ(result.steps, cpu.steps);
      EXPECT_NEAR(result.trainingPsnr, cpu.trainingPsnr, 0.2);
      EXPECT_GT(agreement(result, cpu), cpu.trainingPsnr + 3);
    }
  }
}

TEST_F(DynamicDevice, WithTooLittleMemoryIsNotUsed) {
  for (const char* how : {"small", "make"}) {
    fails(how);
    const DynamicResult result = run(shortFit(DynamicKind::Motion, "cuda"));
    EXPECT_EQ(result.device.id, "cpu");
    ASSERT_EQ(result.notes.size(), 1u);
    EXPECT_TRUE(has(result.notes[0], how == std::string("small") ? "needs about" : "no memory left"))
        << result.notes[0];
  }
}

TEST_F(DynamicDevice, ThatIsNotThereIsRefusedBeforeAnyWork) {
  fails("none");
  const Error error = test::errorOf([&] { run(shortFit(DynamicKind::Motion, "cuda")); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_TRUE(has(error.what(), "No NVIDIA driver is installed.")) << error.what();
  EXPECT_TRUE(notes.empty());
  const DynamicResult result = run(shortFit(DynamicKind::Motion, "auto"));
  EXPECT_TRUE(has(result.device.reason, "No NVIDIA driver is installed."));
  EXPECT_TRUE(result.notes.empty()) << "nothing went wrong";
}

TEST_F(DynamicDevice, IsChosenWhereItPays) {
  const DynamicResult small = run(shortFit(DynamicKind::Motion, "auto"));
  EXPECT_EQ(small.device.id, "cpu");
  EXPECT_TRUE(has(small.device.reason, "The fit is small")) << small.device.reason;
  EXPECT_TRUE(small.notes.empty());
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    Settings endless = shortFit(kind, "auto");
    endless.rounds = 10'000;
    EXPECT_EQ(run(endless, Phase::Initialising).device.id, "cuda:1");
    endless.instructionSet = "scalar";
    EXPECT_TRUE(has(run(endless, Phase::Initialising).device.reason, "which alone supports"));
  }
}

TEST_F(DynamicDevice, LeavesIntensitiesToTheCpuAndSaysSo) {
  const DynamicResult asked = run(shortFit(DynamicKind::Intensity, "cuda:0"));
  EXPECT_EQ(asked.device.id, "cpu");
  EXPECT_TRUE(has(asked.device.reason, "only the CPU does")) << asked.device.reason;
  ASSERT_EQ(asked.notes.size(), 1u);
  EXPECT_EQ(asked.notes[0], asked.device.reason);
  EXPECT_TRUE(run(shortFit(DynamicKind::Intensity, "auto")).notes.empty());
}

TEST_F(DynamicDevice, StopsAndGoesOnOnTheCpu) {
  const Settings settings = shortFit(DynamicKind::Motion, "cuda");
  const DynamicResult stopped = run(settings, Phase::Fitting);
  ASSERT_TRUE(stopped.cancelled);
  ASSERT_FALSE(stopped.state.empty());
  DynamicJob job(series, shortFit(DynamicKind::Motion, "cpu"));
  job.resume(std::make_shared<const StoppedDynamicFit>(StoppedDynamicFit{*stopped.field, stopped.state}));
  EXPECT_GT(agreement(job.run(), run(settings)), 40);
}

TEST_F(DynamicDevice, RendersFramesWhereAsked) {
  Settings settings = shortFit(DynamicKind::Motion, "cpu");
  const DynamicResult result = run(settings);
  const auto frames = [&](const std::string& device, std::string* problem = nullptr) {
    FrameRenderer renderer(*result.field, series.geometry, {}, device);
    std::vector<float> values = renderer.at(0.7);
    const std::vector<float> later = renderer.at(1.6); // another moment than the device held before
    values.insert(values.end(), later.begin(), later.end());
    if (problem) *problem = renderer.problem();
    return values;
  };
  const std::vector<float> cpu = frames("cpu");
  fails("mark");
  EXPECT_EQ(frames("auto"), cpu) << "too small to pay";
  EXPECT_GT(frames("cuda")[5], cpu[5] + 1);
  fails("render");
  EXPECT_EQ(frames("cuda"), cpu);
  fails("");
  const std::vector<float> device = frames("cuda");
  EXPECT_GT(pooledPsnr(device, cpu, {}, 200), 80);
  fails("none");
  EXPECT_THROW(frames("cuda"), Error);
}
