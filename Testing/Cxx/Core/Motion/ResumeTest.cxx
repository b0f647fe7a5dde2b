#include "Core/Motion/DynamicJob.h"
#include "MovingPhantom.h"
#include "ThrownError.h"

#include <cstring>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

Settings shortFit(DynamicKind kind) {
  Settings settings;
  settings.kind = kind;
  settings.rounds = 15;
  return settings;
}

/// Stopped at the n-th report of the refinement; 0: never.
DynamicResult stopped(const TimeSeries& series, const Settings& settings, int at,
                      const std::shared_ptr<const StoppedDynamicFit>& from = {}) {
  DynamicJob job(series, settings);
  if (from) job.resume(from);
  std::stop_source stop;
  int reports = 0;
  job.onProgress([&](const Progress& progress) {
    if (progress.phase == Phase::Fitting && ++reports == at) stop.request_stop();
  });
  return job.run(stop.get_token());
}

std::shared_ptr<const StoppedDynamicFit> fitOf(const DynamicResult& result) {
  return std::make_shared<const StoppedDynamicFit>(StoppedDynamicFit{*result.field, result.state});
}

} // namespace

TEST(DynamicResume, StoppedTwiceAndResumedGivesTheSameBits) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    const Settings settings = shortFit(kind);
    const DynamicResult whole = stopped(series, settings, 0);
    EXPECT_EQ(whole.state.step, whole.steps); // 15 rounds of 6 frames, or as many as are the fewest
    const DynamicResult first = stopped(series, settings, 3);
    ASSERT_TRUE(first.cancelled);
    ASSERT_EQ(first.state.step, 30);
    const DynamicResult second = stopped(series, settings, 2, fitOf(first));
    ASSERT_TRUE(second.cancelled);
    EXPECT_EQ(second.state.step, 50);
    EXPECT_EQ(second.steps, whole.steps);
    const DynamicResult end = stopped(series, settings, 0, fitOf(second));
    EXPECT_FALSE(end.cancelled);
    const DynamicResult again = stopped(series, settings, 0, fitOf(whole)); // nothing is left to do
    EXPECT_EQ(again.field->ownPath, whole.field->ownPath);
    EXPECT_EQ(again.trainingPsnr, whole.trainingPsnr);
    EXPECT_EQ(end.field->nodes, whole.field->nodes);
    EXPECT_EQ(end.field->ownPath, whole.field->ownPath);
    EXPECT_EQ(end.field->network.parameters, whole.field->network.parameters);
    EXPECT_EQ(end.trainingPsnr, whole.trainingPsnr);
    ASSERT_EQ(end.field->size(), whole.field->size());
    EXPECT_EQ(0, std::memcmp(end.field->canonical.gaussians.data(), whole.field->canonical.gaussians.data(),
                             sizeof(Gaussian) * whole.field->canonical.gaussians.size()));
  }
}

TEST(DynamicResume, SaysThatSegmentsAreGone) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  const Settings settings = shortFit(DynamicKind::Motion);
  const DynamicResult first = stopped(series, settings, 1);
  StoppedDynamicFit labelled{*first.field, first.state, true};
  const auto notes = stopped(series, settings, 1, std::make_shared<const StoppedDynamicFit>(labelled)).notes;
  ASSERT_FALSE(notes.empty());
  EXPECT_NE(notes[0].find("learn them again"), std::string::npos) << notes[0];
  EXPECT_EQ(stopped(series, settings, 1, fitOf(first)).notes.size() + 1, notes.size());
}

TEST(DynamicResume, OfAnotherFitIsRefused) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  const Settings settings = shortFit(DynamicKind::Motion);
  const DynamicResult first = stopped(series, settings, 1);
  const auto refusal = [](const TimeSeries& scan, const Settings& asked,
                          const std::shared_ptr<const StoppedDynamicFit>& from) {
    return test::codeOf([&] { stopped(scan, asked, 0, from); });
  };
  Settings other = settings;
  other.rounds = 16;
  EXPECT_EQ(refusal(series, other, fitOf(first)), ErrorCode::InvalidArgument);
  TimeSeries scan = series;
  scan.frames[1][7] += 1;
  EXPECT_EQ(refusal(scan, settings, fitOf(first)), ErrorCode::InvalidArgument);
  StoppedDynamicFit complete{*first.field, {}};
  EXPECT_EQ(refusal(series, settings, std::make_shared<const StoppedDynamicFit>(complete)),
            ErrorCode::InvalidArgument);
  StoppedDynamicFit damaged{*first.field, first.state};
  damaged.state.moments.pop_back();
  EXPECT_EQ(refusal(series, settings, std::make_shared<const StoppedDynamicFit>(damaged)),
            ErrorCode::FileFormat);
}

TEST(DynamicPreview, IsAFieldOfTheFitAndChangesNothing) {
  const TimeSeries series = movingPhantom(evenTimes(5));
  for (const DynamicKind kind : {DynamicKind::Motion, DynamicKind::Network}) {
    DynamicJob job(series, shortFit(kind));
    int previews = 0;
    job.onPreview([&](const std::shared_ptr<const DynamicField>& field) {
      ++previews;
      EXPECT_NO_THROW(checkDynamicField(*field));
      EXPECT_EQ(field->times, series.times);
      EXPECT_EQ(field->kind, kind);
    });
    const DynamicResult shown = job.run(), alone = stopped(series, shortFit(kind), 0);
    EXPECT_GT(previews, 0);
    EXPECT_EQ(shown.field->nodes, alone.field->nodes);
    EXPECT_EQ(shown.field->network.parameters, alone.field->network.parameters);
  }
}

TEST(DynamicSettings, SayHowLongAndHowFine) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  Settings settings = shortFit(DynamicKind::Motion);
  settings.knots = 5;
  settings.nodeDistance = 9;
  const DynamicResult motion = stopped(series, settings, 0);
  EXPECT_EQ(motion.field->motion.coefficients, 5);
  EXPECT_NEAR(motion.field->motionGrid.spacing[0], 9, 1.5);
  EXPECT_TRUE(motion.notes.empty());
  settings = shortFit(DynamicKind::Network);
  settings.knots = 7;
  EXPECT_EQ(coefficientsInTime(*stopped(series, settings, 0).field), 7);
  settings.kind = DynamicKind::Intensity;
  settings.device = "cpu";
  const DynamicResult still = stopped(series, settings, 0);
  EXPECT_EQ(coefficientsInTime(*still.field), 7);
  EXPECT_TRUE(still.notes.empty());
  EXPECT_EQ(still.settings.kind, DynamicKind::Intensity);
  settings.knots = 3;
  EXPECT_THROW(stopped(series, settings, 0), Error);
}
