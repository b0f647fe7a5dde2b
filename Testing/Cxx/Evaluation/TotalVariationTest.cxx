#include "Evaluation/TotalVariation.h"

#include "Core/Base/Error.h"
#include "Core/Image/BodyMask.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/Baselines.h"

#include "../Core/TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

// Two plateaus n wide along an axis: the minimiser moves each towards the other by λ/n.
TEST(TotalVariation, DenoisesAStepAsTheClosedFormSays) {
  for (int axis = 0; axis < 3; ++axis) {
    std::array<std::int64_t, 3> size{4, 4, 4};
    size[axis] = 12;
    const Volume step = volumeOf(grid(size[0], size[1], size[2]), [&](auto i, auto j, auto k) {
      return std::array{i, j, k}[axis] < 6 ? 100. : 300.;
    });
    TotalVariationSettings settings;
    settings.weight = 0.6;
    settings.iterations = 2000;
    const Volume found = totalVariation(std::vector{pointStack(step)}, step.geometry, settings);
    for (std::size_t v = 0; v < found.voxels.size(); ++v)
      ASSERT_NEAR(found.voxels[v], step.voxels[v] == 100 ? 120 : 280, 0.5) << axis << " " << v;
  }
}

TEST(TotalVariation, AgreesWithTheSlicesAlongEveryAxis) {
  const Volume truth = phantom(grid(32, 32, 32));
  const auto mask = bodyMask(truth);
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<Stack> stacks{simulateThickStack(truth, axis, 4)};
    const Volume cubic = averageUpsampled(stacks, truth.geometry, Interpolation::Cubic);
    const Volume found = totalVariation(stacks, truth.geometry);
    EXPECT_GT(pooledPsnr(found.voxels, truth.voxels, mask, 200),
              pooledPsnr(cubic.voxels, truth.voxels, mask, 200));
    const Stack again = simulateThickStack(found, axis, 4);
    EXPECT_GT(pooledPsnr(again.image.voxels, stacks[0].image.voxels, {}, 200), 40);
  }
}

TEST(TotalVariation, SeveralStacksAndUnobservedVoxels) {
  const Volume truth = phantom(grid(24, 24, 24));
  std::vector<Stack> stacks{simulateThickStack(truth, 2, 4)};
  const auto psnr = [&] {
    return pooledPsnr(totalVariation(stacks, truth.geometry).voxels, truth.voxels, {}, 200);
  };
  const double one = psnr();
  stacks.push_back(simulateThickStack(truth, 0, 4));
  EXPECT_GT(psnr(), one + 1);

  Stack holes = pointStack(truth);
  holes.observed.assign(truth.voxels.size(), 1);
  for (std::size_t v = 0; v < holes.observed.size(); v += 5) {
    holes.observed[v] = 0;
    holes.image.voxels[v] = v % 2 ? 1e6f : std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_GT(pooledPsnr(totalVariation(std::vector{holes}, truth.geometry).voxels, truth.voxels, {}, 200),
            20); // the unobserved values would leave nothing
}

TEST(TotalVariation, SameBitsAtAnyNumberOfThreads) {
  const Volume truth = randomVolume(grid(12, 10, 16), 0, 100);
  const std::vector<Stack> stacks{simulateThickStack(truth, 2, 4)};
  TotalVariationSettings settings;
  settings.iterations = 10;
  settings.threads = 1;
  const Volume one = totalVariation(stacks, truth.geometry, settings);
  settings.threads = 5;
  EXPECT_EQ(totalVariation(stacks, truth.geometry, settings).voxels, one.voxels);
}

TEST(TotalVariation, RefusesOtherPixelsAndStops) {
  const Volume truth = randomVolume(grid(8, 8, 8), 0, 1);
  const std::vector<Stack> stacks{simulateThickStack(truth, 2, 4)};
  EXPECT_THROW(totalVariation(stacks, grid(8, 8, 8, {0.5, 0.5, 0.5})), Error);
  EXPECT_THROW(totalVariation(stacks, grid(8, 8, 8, {1, 1, 1}, {0, 0, 0}, obliqueDirection(0.5))), Error);
  std::stop_source source;
  source.request_stop();
  TotalVariationSettings settings;
  settings.stop = source.get_token();
  EXPECT_THROW(totalVariation(stacks, truth.geometry, settings), Error);
}
