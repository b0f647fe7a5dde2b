#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/DynamicSampler.h"
#include "Core/Motion/MotionField.h"
#include "MovingPhantom.h"

#include "Core/Base/Error.h"
#include "Core/Image/Metrics.h"
#include "Core/Render/Render.h"

#include <array>
#include <cstring>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr std::array kKinds{DynamicKind::Motion, DynamicKind::Intensity, DynamicKind::Network};

DynamicResult runOn(const TimeSeries& series, std::optional<DynamicKind> kind, int threads = 0,
                    std::optional<int> rounds = {}) {
  Settings settings;
  settings.kind = kind;
  settings.threads = threads;
  settings.rounds = rounds;
  return DynamicJob(series, settings).run();
}

double psnrAt(const DynamicField& field, const GridGeometry& geometry, double time,
              const std::vector<float>& truth) {
  return pooledPsnr(render(fieldAt(field, time), geometry).voxels, truth, {}, 200);
}

std::vector<float> between(const std::vector<float>& a, const std::vector<float>& b, double w) {
  std::vector<float> mean;
  for (std::size_t v = 0; v < a.size(); ++v)
    mean.push_back(a[v] + static_cast<float>(w) * (b[v] - a[v]));
  return mean;
}

/// A still phantom whose blobs glow in turn, with noise.
TimeSeries glowing(int count, double noise) {
  TimeSeries series{phantomGrid(), {}, evenTimes(count, 2), "glow", {}};
  for (int f = 0; f < count; ++f) {
    Volume frame = volumeInSpace(series.geometry, [&](const Vec3& x) {
      return blobs(x) * (1 + 0.1 * std::sin(0.35 * f + 0.2 * x[0]));
    });
    const Volume added = randomVolume(series.geometry, -noise, noise, 100 + f);
    for (std::size_t v = 0; v < frame.voxels.size(); ++v)
      frame.voxels[v] += added.voxels[v];
    series.frames.push_back(frame.voxels);
  }
  return series;
}

DynamicResult stoppedIn(Phase at, const TimeSeries& series, DynamicKind kind) {
  std::stop_source stop;
  Settings settings;
  settings.kind = kind;
  DynamicJob job(series, settings);
  job.onProgress([&](const Progress& progress) {
    if (progress.phase == at) stop.request_stop();
  });
  DynamicResult result = job.run(stop.get_token());
  EXPECT_TRUE(result.cancelled) << phaseName(at);
  return result;
}

} // namespace

class RigidMotionOf : public ::testing::TestWithParam<std::optional<DynamicKind>> {};

TEST_P(RigidMotionOf, IsRecoveredAtTimesThatItNeverSaw) {
  const TimeSeries all = movingPhantom(evenTimes(13));
  const std::vector<std::int64_t> heldOut{3, 6, 9};
  std::vector<std::int64_t> kept;
  for (std::int64_t f = 0; f < all.size(); ++f)
    if (std::find(heldOut.begin(), heldOut.end(), f) == heldOut.end()) kept.push_back(f);
  const TimeSeries series = framesOf(all, kept);
  const DynamicResult result = runOn(series, GetParam());
  ASSERT_TRUE(result.field);
  const DynamicField& field = *result.field;
  EXPECT_EQ(field.kind, GetParam().value_or(DynamicKind::Motion)) << result.choice;
  EXPECT_EQ(result.choice.empty(), GetParam().has_value());
  const double reference = series.times[series.size() / 2]; // where the canonical field is fitted
  for (const std::int64_t f : heldOut) {
    const auto linear = between(all.frames[f - 1], all.frames[f + 1], 0.5);
    // 5.6 to 8.4 dB, as the instruction sets round differently.
    EXPECT_GT(psnrAt(field, all.geometry, all.times[f], all.frames[f]),
              pooledPsnr(linear, all.frames[f], {}, 200) + 5)
        << f;
    // Landmarks: where the blobs are. What moves by u(t) from the canonical field's place.
    double sum = 0;
    int landmarks = 0;
    for (int n = 0; n < 9; ++n) {
      const Vec3 landmark{6.0 * (n % 3) - 6 + 0.7 * n, 6.0 * (n / 3) - 6, 1.5 * (n % 4) - 2};
      const Vec3 from = swing(reference)(landmark), to = swing(all.times[f])(landmark);
      const GridGeometry point = grid(1, 1, 1, {1, 1, 1}, from);
      const std::vector<float> moved = motionField(field, reference, all.times[f], point);
      if (std::abs(from[0]) > 9 || std::abs(from[1]) > 8) continue; // near the edge of what is seen
      sum += norm(from + Vec3{moved[0], moved[1], moved[2]} - to);
      ++landmarks;
    }
    ASSERT_GT(landmarks, 3);
    EXPECT_LT(sum / landmarks, 0.5) << f; // voxels of 1 mm
  }
}

INSTANTIATE_TEST_SUITE_P(DynamicJob, RigidMotionOf,
                         ::testing::Values(std::nullopt, std::optional(DynamicKind::Network)));

TEST(DynamicJob, UnevenTimesAreHonoured) {
  const std::vector<double> times{0, 0.5, 0.9, 1.2, 2, 2.3, 3.1, 3.5, 4, 4.6, 5, 5.5};
  const DynamicResult result = runOn(movingPhantom(times), DynamicKind::Motion);
  EXPECT_EQ(result.field->times, times);
  const TimeSeries truth = movingPhantom({1.6, 2.7});
  for (std::int64_t f = 0; f < truth.size(); ++f)
    EXPECT_GT(psnrAt(*result.field, truth.geometry, truth.times[f], truth.frames[f]), 30) << truth.times[f];
}

TEST(DynamicJob, WhatStaysConstantStaysSo) {
  TimeSeries series = movingPhantom(evenTimes(6));
  for (auto& frame : series.frames)
    frame = series.frames[0];
  series.frames[2][0] += 1e-3F; // frames that are all equal are refused
  for (const DynamicKind kind : kKinds) {
    const DynamicResult result = runOn(series, kind);
    const Volume first = render(fieldAt(*result.field, 0), series.geometry);
    for (const double time : {0.3, 1.1, 2.5}) {
      const Volume then = render(fieldAt(*result.field, time), series.geometry);
      EXPECT_GT(pooledPsnr(then.voxels, first.voxels, {}, 200), 55) << dynamicKindName(kind) << time;
      EXPECT_GT(pooledPsnr(then.voxels, series.frames[0], {}, 200), 38) << dynamicKindName(kind) << time;
    }
  }
}

TEST(DynamicJob, ChangingIntensitiesAreChosenAndBeatLinearInterpolation) {
  const TimeSeries noisy = glowing(24, 8), clean = glowing(24, 0);
  std::vector<std::int64_t> kept;
  for (std::int64_t f = 0; f < noisy.size(); ++f)
    if (f % 6 != 3) kept.push_back(f);
  const DynamicResult result = runOn(framesOf(noisy, kept), {});
  EXPECT_EQ(result.field->kind, DynamicKind::Intensity) << result.choice;
  for (std::int64_t f = 3; f < noisy.size(); f += 6) {
    const auto linear = between(noisy.frames[f - 1], noisy.frames[f + 1], 0.5);
    EXPECT_GT(psnrAt(*result.field, noisy.geometry, noisy.times[f], clean.frames[f]),
              pooledPsnr(linear, clean.frames[f], {}, 200) + 1.5);
  }
}

TEST(DynamicJob, BrokenVoxelsAreLeftOut) {
  TimeSeries series = movingPhantom(evenTimes(6));
  const TimeSeries truth = series;
  for (std::size_t f = 0; f < series.frames.size(); ++f)
    for (std::size_t v = f; v < series.frames[f].size(); v += 97)
      series.frames[f][v] = std::numeric_limits<float>::quiet_NaN();
  std::fill_n(series.frames[3].begin(), 24 * 22, std::numeric_limits<float>::infinity()); // a slice
  for (const DynamicKind kind : kKinds) {
    const DynamicResult result = runOn(series, kind, 0, 12);
    const Volume then = render(fieldAt(*result.field, 0.5), series.geometry);
    for (const float value : then.voxels)
      ASSERT_TRUE(std::isfinite(value));
    EXPECT_GT(pooledPsnr(then.voxels, truth.frames[1], {}, 200), 28) << dynamicKindName(kind);
  }
}

TEST(DynamicJob, SameBitsAtAnyNumberOfThreads) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  for (const std::optional<DynamicKind> kind :
       {std::optional(DynamicKind::Intensity), std::optional(DynamicKind::Network),
        std::optional<DynamicKind>()}) {
    const DynamicResult one = runOn(series, kind, 1, 8), three = runOn(series, kind, 3, 8);
    ASSERT_EQ(one.field->size(), three.field->size());
    EXPECT_EQ(one.field->nodes, three.field->nodes);
    EXPECT_EQ(one.field->ownPath, three.field->ownPath);
    EXPECT_EQ(one.field->changes, three.field->changes);
    EXPECT_EQ(one.field->network.parameters, three.field->network.parameters);
    EXPECT_EQ(0, std::memcmp(one.field->canonical.gaussians.data(), three.field->canonical.gaussians.data(),
                             sizeof(Gaussian) * one.field->canonical.gaussians.size()));
  }
}

TEST(DynamicJob, StopsInEveryPhaseAndKeepsWhatWasRefined) {
  const TimeSeries series = movingPhantom(evenTimes(6));
  std::vector<Phase> phases;
  for (const Phase at : {Phase::Preparing, Phase::Initialising, Phase::Tracking, Phase::Fitting}) {
    std::stop_source stop;
    DynamicJob job(series, {});
    double last = 0;
    job.onProgress([&](const Progress& progress) {
      EXPECT_GE(progress.fraction, last);
      last = progress.fraction;
      if (progress.phase == at) stop.request_stop();
      if (phases.empty() || phases.back() != progress.phase) phases.push_back(progress.phase);
    });
    const DynamicResult result = job.run(stop.get_token());
    EXPECT_TRUE(result.cancelled) << phaseName(at);
    EXPECT_EQ(result.field != nullptr, at == Phase::Fitting) << phaseName(at);
    if (result.field) {
      EXPECT_NO_THROW(checkDynamicField(*result.field));
    }
  }
}

TEST(DynamicJob, StoppedInTheNetworksTrainingKeepsTheField) {
  for (const Phase at : {Phase::Initialising, Phase::Fitting}) {
    const DynamicResult result = stoppedIn(at, movingPhantom(evenTimes(6)), DynamicKind::Network);
    EXPECT_EQ(result.field != nullptr, at == Phase::Fitting) << phaseName(at);
    if (result.field) {
      EXPECT_NO_THROW(checkDynamicField(*result.field));
    }
  }
}

TEST(DynamicJob, StoppedWhileIntensitiesAreSolvedForThereIsNoField) {
  for (const Phase at : {Phase::Preparing, Phase::Initialising, Phase::Fitting}) {
    const DynamicResult result = stoppedIn(at, glowing(12, 2), DynamicKind::Intensity);
    EXPECT_EQ(result.field, nullptr) << phaseName(at);
    EXPECT_TRUE(result.state.empty());
  }
}

TEST(DynamicJob, RefusesBeforeAnyWork) {
  Settings settings;
  settings.gaussians = 0;
  EXPECT_THROW(DynamicJob(movingPhantom(evenTimes(3)), settings).run(), Error);
  settings = {};
  settings.instructionSet = "none such";
  EXPECT_THROW(DynamicJob(movingPhantom(evenTimes(3)), settings).run(), Error);
  EXPECT_THROW(DynamicJob(movingPhantom({0}), {}).run(), Error);
}

TEST(DynamicSampler, APlaneAtATimeIsTheFieldsAtThatTime) {
  const TimeSeries series = movingPhantom(evenTimes(5));
  for (const DynamicKind kind : kKinds) {
    const DynamicResult result = runOn(series, kind, 0, 8);
    DynamicSampler sampler(result.field);
    const int nx = 24, ny = 22;
    std::vector<float> plane(nx * ny);
    for (const auto& [time, slice] :
         {std::pair{0.7, 3}, std::pair{0.7, 5}, std::pair{1.9, 5}, std::pair{0.7, 3}}) {
      const Volume whole = render(fieldAt(*result.field, time), series.geometry);
      Affine3 pose = series.geometry.indexToWorld();
      pose.offset = pose({0, 0, static_cast<double>(slice)});
      sampler.sample(pose, time, nx, ny, plane);
      for (int v = 0; v < nx * ny; ++v)
        ASSERT_NEAR(plane[v], whole.voxels[slice * nx * ny + v], 1e-3) << dynamicKindName(kind) << time;
    }
    EXPECT_THROW(sampler.sample(series.geometry.indexToWorld(), std::numeric_limits<double>::quiet_NaN(), nx,
                                ny, plane),
                 Error);
  }
}

TEST(DynamicField, BrokenOnesAreRefused) {
  const TimeSeries series = movingPhantom(evenTimes(4));
  const DynamicField whole = *runOn(series, DynamicKind::Motion).field;
  EXPECT_NO_THROW(checkDynamicField(whole));
  DynamicField field = whole;
  field.nodes.pop_back();
  EXPECT_THROW(checkDynamicField(field), Error);
  field = whole;
  field.anchors[4] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(checkDynamicField(field), Error);
  field = whole;
  field.motion.coefficients = 3;
  EXPECT_THROW(checkDynamicField(field), Error);
  field = whole;
  field.times = {1, 0};
  EXPECT_THROW(checkDynamicField(field), Error);
  field = whole;
  field.kind = DynamicKind::Intensity; // without any
  EXPECT_THROW(checkDynamicField(field), Error);
}
