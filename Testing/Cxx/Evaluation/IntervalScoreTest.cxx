#include "Evaluation/IntervalScore.h"

#include "Core/Image/Simulate.h"

#include <gtest/gtest.h>
#include <vector>

using namespace innergs;

namespace {

constexpr std::int64_t kVoxels = 40000;

Volume line(float value) {
  GridGeometry geometry;
  geometry.size = {kVoxels, 1, 1};
  return {geometry, std::vector<float>(kVoxels, value)};
}

double held(double error, double deviation, double noiseOfTruth, double assumed) {
  Volume image = line(7), truth = line(7);
  addNoise(image.voxels, error, 1);
  addNoise(truth.voxels, noiseOfTruth, 2);
  return intervalScore(image, truth, std::vector<std::uint8_t>(kVoxels, 1), {},
                       line(static_cast<float>(deviation)), assumed)
      .coverage;
}

TEST(IntervalScore, HoldsNinetyPercentOfNormalErrorsOfTheStatedDeviation) {
  EXPECT_NEAR(held(3, 3, 0, 0), 0.9, 0.005);
  EXPECT_GT(held(3, 6, 0, 0), 0.99);
  EXPECT_LT(held(3, 1.5, 0, 0), 0.65);
}

TEST(IntervalScore, AllowsForTheNoiseOfTheTruth) {
  EXPECT_NEAR(held(3, 3, 4, 4), 0.9, 0.005);
  EXPECT_LT(held(3, 3, 4, 0), 0.75);
}

TEST(IntervalScore, CountsTheMaskAlone) {
  Volume image = line(7), truth = line(7);
  std::vector<std::uint8_t> mask(kVoxels, 1);
  truth.voxels[3] = 100;
  const auto coverage = [&] { return intervalScore(image, truth, mask, {}, line(1), 0).coverage; };
  EXPECT_LT(coverage(), 1);
  mask[3] = 0;
  EXPECT_EQ(coverage(), 1);
}

} // namespace
