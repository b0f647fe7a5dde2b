#include "Core/Motion/DynamicJob.h"
#include "MovingPhantom.h"

#include "Core/Base/Error.h"
#include "Core/Image/Metrics.h"
#include "Core/Render/Render.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr double kInterval = 2; // s between frames

/// Even slices first, as interleaved fMRI has them.
SliceTiming interleaved(std::int64_t slices) {
  SliceTiming timing;
  timing.times.resize(slices);
  int order = 0;
  for (const std::int64_t from : {0, 1})
    for (std::int64_t s = from; s < slices; s += 2)
      timing.times[s] = kInterval / static_cast<double>(slices) * order++;
  return timing;
}

/// A still phantom that glows with a period of 7 frames.
double glow(const Vec3& x, double time) {
  return blobs(x) * (1 + 0.2 * std::sin(2 * 3.14159265358979 * time / (7 * kInterval) + 0.05 * x[0]));
}

std::vector<float> momentAt(const GridGeometry& grid, double time) {
  return volumeInSpace(grid, [&](const Vec3& x) { return glow(x, time); }).voxels;
}

/// Slices at their own times, with some noise.
TimeSeries acquired(int frames) {
  TimeSeries series{phantomGrid(), {}, evenTimes(frames, kInterval), "bold", {}};
  series.sliceTiming = interleaved(series.geometry.size[2]);
  const std::int64_t slice = series.geometry.size[0] * series.geometry.size[1];
  for (int f = 0; f < frames; ++f) {
    auto& frame = series.frames.emplace_back();
    for (std::int64_t k = 0; k < series.geometry.size[2]; ++k) {
      const auto moment = momentAt(series.geometry, series.times[f] + series.sliceTiming.times[k]);
      frame.insert(frame.end(), moment.begin() + k * slice, moment.begin() + (k + 1) * slice);
    }
    const Volume noise = randomVolume(series.geometry, -1, 1, 50 + f);
    for (std::size_t v = 0; v < frame.size(); ++v)
      frame[v] += noise.voxels[v];
  }
  return series;
}

} // namespace

TEST(SliceTiming, VoxelsBelongToTheirSlices) {
  const GridGeometry grid = phantomGrid();
  for (int axis = 0; axis < 3; ++axis) {
    SliceTiming timing = interleaved(grid.size[axis]);
    timing.axis = axis;
    timing.times[0] = timing.times[1]; // two at once
    const SliceGroups groups = sliceGroups(timing, grid);
    EXPECT_EQ(groups.times.size(), timing.times.size() - 1);
    std::int64_t next = 5;
    groups.runs(5, grid.voxelCount() - 3, [&](std::int64_t begin, std::int64_t end, int group) {
      ASSERT_EQ(begin, next);
      ASSERT_GT(end, begin);
      next = end;
      for (std::int64_t v = begin; v < end; ++v) {
        const std::int64_t at[3] = {v % grid.size[0], v / grid.size[0] % grid.size[1],
                                    v / (grid.size[0] * grid.size[1])};
        ASSERT_EQ(groups.times[group], timing.times[at[axis]]);
      }
    });
    EXPECT_EQ(next, grid.voxelCount() - 3);
  }
  EXPECT_EQ(sliceGroups({}, grid).times, std::vector<double>{0});
}

TEST(SliceTiming, TakingItIntoAccountShowsMomentsBetter) {
  const TimeSeries series = acquired(30);
  double psnr[2];
  for (const bool honoured : {false, true}) {
    Settings settings;
    settings.kind = DynamicKind::Intensity;
    settings.sliceTiming = honoured;
    settings.knots = 24;
    const DynamicResult result = DynamicJob(series, settings).run();
    EXPECT_EQ(result.slicesTimed, honoured);
    EXPECT_TRUE(result.notes.empty());
    EXPECT_GT(result.trainingPsnr, 30); // each slice scored at its own time
    std::vector<float> shown, truth;
    for (const double time : {12.5, 21.0, 33.3, 40.0}) {
      const Volume volume = render(fieldAt(*result.field, time), series.geometry);
      const auto moment = momentAt(series.geometry, time);
      shown.insert(shown.end(), volume.voxels.begin(), volume.voxels.end());
      truth.insert(truth.end(), moment.begin(), moment.end());
    }
    psnr[honoured] = pooledPsnr(shown, truth, {}, 200);
  }
  EXPECT_GT(psnr[1], psnr[0] + 6);
}

TEST(SliceTiming, AFrameAsAcquiredHasItsSlicesAtTheirTimes) {
  TimeSeries series = acquired(8);
  Settings settings;
  settings.kind = DynamicKind::Intensity;
  const DynamicResult result = DynamicJob(series, settings).run();
  for (int axis = 0; axis < 3; ++axis) {
    series.sliceTiming = interleaved(series.geometry.size[axis]);
    series.sliceTiming.axis = axis;
    const auto frame = acquiredFrame(*result.field, series, 3.5, {});
    const SliceGroups groups = sliceGroups(series.sliceTiming, series.geometry);
    for (const std::int64_t s : {std::int64_t{0}, std::int64_t{3}}) {
      const Volume whole = render(fieldAt(*result.field, 3.5 + series.sliceTiming.times[s]), series.geometry);
      for (std::int64_t v = 0; v < series.geometry.voxelCount(); ++v)
        if (v / groups.step % groups.slices == s) {
          ASSERT_NEAR(frame[v], whole.voxels[v], 1e-3) << axis;
        }
    }
  }
}

TEST(SliceTiming, WhereGaussiansMoveASentenceSaysThatItIsNotUsed) {
  TimeSeries series = movingPhantom(evenTimes(4, kInterval));
  series.sliceTiming = interleaved(series.geometry.size[2]);
  Settings settings;
  settings.kind = DynamicKind::Motion;
  settings.rounds = 1;
  const DynamicResult result = DynamicJob(series, settings).run();
  ASSERT_EQ(result.notes.size(), 1u);
  EXPECT_NE(result.notes[0].find("acquired at its start"), std::string::npos);
  EXPECT_FALSE(result.slicesTimed);
}

TEST(SliceTiming, OfAnotherGridIsRefused) {
  TimeSeries series = movingPhantom(evenTimes(3, kInterval));
  series.sliceTiming.times = {0, 1};
  EXPECT_THROW(checkTimeSeries(series), Error);
  series.sliceTiming = interleaved(series.geometry.size[2]);
  EXPECT_NO_THROW(checkTimeSeries(series));
  series.sliceTiming.times[2] = -1;
  EXPECT_THROW(checkTimeSeries(series), Error);
  series.sliceTiming.times[2] = 1.1 * kInterval; // in the next frame
  EXPECT_THROW(checkTimeSeries(series), Error);
}
