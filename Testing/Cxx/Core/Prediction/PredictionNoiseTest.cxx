#include "Core/Prediction/PredictionNoise.h"

#include "Core/Image/Simulate.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace innergs::testing {
namespace {

constexpr std::int64_t kPlane = 40 * 40;
constexpr double kNoise = 5;

struct Case {
  Volume missed;
  Stack predicted;
};

/// A constant fitted field, predicted with noise in every second plane.
Case noisyCase() {
  Case c;
  c.missed = {grid(40, 40, 8, {1, 1, 1}), std::vector<float>(8 * kPlane, 0.f)};
  for (std::int64_t k = 0; k < 8; k += 2) {
    std::vector<float> noise(kPlane, 0.f);
    addNoise(noise, kNoise, static_cast<std::uint64_t>(k) + 1);
    std::copy(noise.begin(), noise.end(), c.missed.voxels.begin() + k * kPlane);
  }
  c.predicted.image = c.missed;
  for (float& v : c.predicted.image.voxels)
    v += 100;
  return c;
}

double rms(const Volume& volume) {
  double sum = 0;
  for (const float v : volume.voxels)
    sum += static_cast<double>(v) * v;
  return std::sqrt(sum / static_cast<double>(volume.voxels.size()));
}

TEST(PredictionNoise, IsRemovedFromBoth) {
  ThreadPool pool(2);
  Case c = noisyCase();
  const double before = rms(c.missed);
  removePredictionNoise(c.missed, c.predicted, kNoise, pool);
  EXPECT_LT(rms(c.missed), 0.4 * before);
  for (std::size_t v = 0; v < c.missed.voxels.size(); ++v)
    ASSERT_NEAR(c.predicted.image.voxels[v], 100 + c.missed.voxels[v], 1e-4);
}

TEST(PredictionNoise, IsAtMostThatOfTheScan) {
  ThreadPool pool(2);
  Case c = noisyCase();
  const double before = rms(c.missed);
  removePredictionNoise(c.missed, c.predicted, 0.1 * kNoise, pool);
  EXPECT_GT(rms(c.missed), 0.98 * before) << "what a noiseless scan shows is structure";
}

TEST(PredictionNoise, LeavesMostOfAllElseThatIsMissed) {
  ThreadPool pool(2);
  Case c = noisyCase();
  for (std::size_t v = 0; v < c.missed.voxels.size(); ++v)
    c.missed.voxels[v] += v % 40 < 20 ? 20.f : -20.f;
  const double before = rms(c.missed);
  removePredictionNoise(c.missed, c.predicted, kNoise, pool);
  EXPECT_GT(rms(c.missed), 0.95 * before);
}

TEST(PredictionNoise, TextureIsNone) {
  ThreadPool pool(2);
  Case c;
  c.missed = c.predicted.image = texture(grid(64, 64, 6));
  for (float& v : c.missed.voxels)
    v -= 100;
  const double before = rms(c.missed);
  removePredictionNoise(c.missed, c.predicted, 1e9, pool);
  EXPECT_GT(rms(c.missed), 0.97 * before);
}

TEST(PredictionNoise, OfSlicesThatRepeatEachOtherIsPredicted) {
  Stack scan;
  scan.image = volumeOf(grid(64, 64, 12), [](auto, auto, auto) { return 100; });
  addNoise(scan.image.voxels, kNoise, std::uint64_t{3});
  EXPECT_EQ(unpredictedNoise(scan, kNoise), kNoise);
  for (std::size_t v = 64 * 64; v < scan.image.voxels.size(); ++v)
    scan.image.voxels[v] = scan.image.voxels[v - 64 * 64];
  EXPECT_EQ(unpredictedNoise(scan, kNoise), 0);
}

} // namespace
} // namespace innergs::testing
