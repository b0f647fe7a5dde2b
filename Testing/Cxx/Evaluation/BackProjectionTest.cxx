#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/ProjectToStack.h"
#include "Evaluation/BackProjectionBaseline.h"

#include "Core/Alignment/Rigid.h"
#include "Core/Base/Error.h"
#include "Core/Image/BodyMask.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/Baselines.h"

#include "../Core/TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

ThreadPool pool;

double residual(const Volume& volume, std::span<const Stack> stacks) {
  double squares = 0, count = 0;
  for (const Stack& stack : stacks) {
    const auto seen = projectToStack(volume, stack, pool);
    for (std::size_t p = 0; p < seen.size(); ++p)
      if (std::isfinite(seen[p])) {
        squares += std::pow(double(seen[p]) - stack.image.voxels[p], 2);
        ++count;
      }
  }
  return std::sqrt(squares / count);
}

} // namespace

TEST(BackProjection, ProjectionOfTheTruthIsTheSimulatedStack) {
  const Volume truth =
      randomVolume(grid(12, 16, 20, {1, 1.5, 2}, {3, 2, 1}, obliqueDirection(0.5, true)), 0, 100);
  for (int axis = 0; axis < 3; ++axis) {
    const Stack stack = simulateThickStack(truth, axis, 4);
    const auto seen = projectToStack(truth, stack, pool);
    for (std::size_t p = 0; p < seen.size(); ++p)
      ASSERT_NEAR(seen[p], stack.image.voxels[p], 1e-3);
  }
}

TEST(BackProjection, ObliqueProfilesKeepRamps) {
  const auto ramp = [](const Vec3& x) { return 2 * x[0] - x[1] + 0.5 * x[2]; };
  const Volume truth = volumeInSpace(grid(30, 30, 30, {1, 1, 1}, {-15, -15, -15}), ramp);
  Stack stack;
  stack.image = volumeInSpace(grid(6, 6, 3, {1, 1, 4}, {-3, -2, -4}, obliqueDirection(0.5)), ramp);
  stack.thickness = 4;
  for (const SliceProfile profile : {SliceProfile::Point, SliceProfile::Box, SliceProfile::Gaussian}) {
    stack.profile = profile;
    const auto seen = projectToStack(truth, stack, pool);
    for (std::size_t p = 0; p < seen.size(); ++p)
      ASSERT_NEAR(seen[p], stack.image.voxels[p], 1e-3);
  }
}

// Slices that one rigid transform poses alike lie where a header moved by it puts them.
TEST(BackProjection, PosesThatAreAllAlikeMoveTheStack) {
  const Volume truth = phantom(grid(24, 24, 24));
  const Affine3 motion = rigidAbout(truth.geometry.centre(), {0.1, -0.2, 0.15}, {1.5, -0.7, 2});
  const auto solved = [&](const Stack& stack) {
    Volume volume{truth.geometry, std::vector<float>(truth.voxels.size(), 50.f)};
    backProject(volume, {&stack, 1}, {.iterations = 2}, pool);
    return volume.voxels;
  };
  for (const bool moved : {false, true}) {
    Stack posed = simulateThickStack(truth, 2, 4), still = posed;
    posed.poses.assign(static_cast<std::size_t>(posed.image.geometry.size[2]), moved ? motion : Affine3{});
    if (moved) {
      still.image.geometry.direction = motion.linear * still.image.geometry.direction;
      still.image.geometry.origin = motion(still.image.geometry.origin);
    }
    const std::vector<float> a = solved(posed), b = solved(still);
    // At a stack's faces, posed slices fade out and a stack ends.
    const GridGeometry& g = still.image.geometry;
    const Affine3 toIndex = inverse(g.indexToWorld());
    int compared = 0;
    for (std::size_t v = 0; v < a.size(); ++v) {
      const auto at = static_cast<std::int64_t>(v);
      const Vec3 index = toIndex(truth.geometry.indexToWorld()(
          {static_cast<double>(at % 24), static_cast<double>(at / 24 % 24), static_cast<double>(at / 576)}));
      bool inside = true;
      for (int axis = 0; axis < 3; ++axis)
        inside = inside &&
                 std::abs(index[axis] - 0.5 * static_cast<double>(g.size[axis] - 1)) < (axis == 2 ? 1.5 : 9);
      if (!inside) continue;
      ASSERT_NEAR(a[v], b[v], 1e-3) << v << moved;
      ++compared;
    }
    EXPECT_GT(compared, 2000);
  }
}

TEST(BackProjection, GaussianProfileHasItsWidth) {
  // A single bright plane, seen by slices at many offsets: the response is the profile.
  const Volume truth =
      volumeOf(grid(4, 4, 201, {1, 1, 0.1}), [](auto, auto, auto k) { return k == 100 ? 10.0 : 0.0; });
  Stack stack;
  stack.profile = SliceProfile::Gaussian;
  stack.thickness = 4;
  stack.image.geometry = grid(4, 4, 161, {1, 1, 0.1}, {0, 0, 2});
  stack.image.voxels.assign(4 * 4 * 161, 0);
  const auto seen = projectToStack(truth, stack, pool);
  const auto at = [&](int k) { return double(seen[5 + 16 * static_cast<std::size_t>(k)]); };
  EXPECT_NEAR(at(80 + 20) / at(80), 0.5, 0.02); // half maximum at half the thickness
  EXPECT_NEAR(at(80 - 20) / at(80), 0.5, 0.02);
}

TEST(BackProjection, AddsLessBetweenSlicesThatMovedApart) {
  Stack stack;
  stack.image = volumeOf(grid(8, 8, 2, {1, 1, 4}), [](auto, auto, auto) { return 100; });
  stack.poses = {Affine3{}, rigidAbout({}, {}, {0, 0, 4})}; // at 0 and 8 mm
  Volume volume{grid(8, 8, 9), std::vector<float>(8 * 8 * 9, 0.f)};
  backProject(volume, {&stack, 1}, {.iterations = 1}, pool);
  const auto at = [&](std::int64_t k) {
    return volume.voxels[static_cast<std::size_t>(4 + 8 * (4 + 8 * k))];
  };
  EXPECT_NEAR(at(0), 100, 1e-3);
  EXPECT_NEAR(at(2), 50, 1e-3) << "half a slice distance from one of them";
  EXPECT_EQ(at(4), 0) << "reached by neither";
  EXPECT_NEAR(at(8), 100, 1e-3);
}

TEST(BackProjection, ReducesTheDataResidualAndTheError) {
  const Volume truth = phantom(grid(32, 32, 32));
  const auto mask = bodyMask(truth);
  for (const int count : {1, 2, 3}) {
    std::vector<Stack> stacks;
    for (int s = 0; s < count; ++s)
      stacks.push_back(simulateThickStack(truth, 2 - s, 4));
    const Volume start = averageUpsampled(stacks, truth.geometry, Interpolation::Cubic);
    BackProjectionSettings settings;
    settings.stopAtNoise = false;
    double before = residual(start, stacks);
    for (const int iterations : {1, 3, 12}) {
      settings.iterations = iterations;
      const double after = residual(backProjectionBaseline(stacks, truth.geometry, settings), stacks);
      EXPECT_LT(after, before);
      before = after;
    }
    EXPECT_LT(before, 0.2 * residual(start, stacks));
    EXPECT_GT(pooledPsnr(backProjectionBaseline(stacks, truth.geometry).voxels, truth.voxels, mask, 200),
              pooledPsnr(start.voxels, truth.voxels, mask, 200));
  }
}

// A dark spot of few voxels is not an outlier: it is kept, and no value leaves the observed range.
TEST(BackProjection, StaysWithinTheRangeWithoutErasingASpot) {
  const Volume truth = volumeOf(grid(40, 40, 40), [](auto i, auto j, auto k) {
    if (k >= 16 && k < 24 && i >= 20 && i < 22 && j >= 20 && j < 22) return 0;
    return (i / 10 + j / 10 + k / 8) % 2 ? 300 : 220;
  });
  const std::vector<Stack> stacks{simulateThickStack(truth, 2, 4)};
  BackProjectionPlan plan;
  plan.range = observedRange(stacks);
  ASSERT_EQ(plan.range.low, 0);
  ASSERT_EQ(plan.range.high, 300);
  Volume volume = averageUpsampled(stacks, truth.geometry, Interpolation::Cubic);
  backProject(volume, stacks, plan, pool);
  const auto [low, high] = std::minmax_element(volume.voxels.begin(), volume.voxels.end());
  EXPECT_GE(*low, 0);
  EXPECT_LE(*high, 300);
  EXPECT_LT(volume.voxels[20 + 40 * (20 + 40 * 18)], 20);
}

TEST(BackProjection, StopsBeforeItFitsTheNoise) {
  const Volume truth = phantom(grid(48, 48, 48));
  std::vector<Stack> stacks;
  for (int s = 0; s < 2; ++s)
    stacks.push_back(simulateThickStack(truth, 2 - s, 4, 25, 3 + s));
  BackProjectionSettings all;
  all.iterations = 30;
  all.stopAtNoise = false;
  EXPECT_GT(pooledPsnr(backProjectionBaseline(stacks, truth.geometry).voxels, truth.voxels, {}, 200),
            pooledPsnr(backProjectionBaseline(stacks, truth.geometry, all).voxels, truth.voxels, {}, 200));
}

TEST(BackProjection, AddsDetailWithoutTheNoiseOfSeveralScans) {
  const Volume truth = phantom(grid(40, 40, 40));
  const auto mask = bodyMask(truth);
  const auto gain = [&](double noise, double told) { // dB
    std::vector<Stack> stacks;
    for (int axis = 0; axis < 3; ++axis)
      stacks.push_back(simulateThickStack(truth, axis, 4, noise, 5 + axis));
    Volume volume = truth; // without its finest detail
    for (std::size_t v = 1; v + 1 < volume.voxels.size(); ++v)
      volume.voxels[v] = (truth.voxels[v - 1] + truth.voxels[v] + truth.voxels[v + 1]) / 3;
    const double before = pooledPsnr(volume.voxels, truth.voxels, mask, 200);
    BackProjectionPlan plan;
    plan.noise = told;
    const double rms = backProject(volume, stacks, plan, pool);
    if (told > 1) {
      EXPECT_GT(rms, 0.5 * noise) << "from the slices as they are";
    }
    return pooledPsnr(volume.voxels, truth.voxels, mask, 200) - before;
  };
  EXPECT_GT(gain(0, 0), 4);
  EXPECT_GT(gain(0, 0.5), gain(0, 0) - 0.1);
  EXPECT_GT(gain(6, 6), gain(6, 0) + 2);
  EXPECT_LT(gain(12, 0), 0);
  EXPECT_GT(gain(12, 12), 1.5);
}

TEST(BackProjection, SpreadsOverSlicesOnlyWhereBoxesOverlapByMoreThanHalf) {
  for (const double thickness : {0.0, 1.0, 2.0})
    EXPECT_EQ(spreadingWeights(SliceProfile::Box, thickness), std::vector<double>{1});
  EXPECT_EQ(spreadingWeights(SliceProfile::Gaussian, 4), std::vector<double>{1});
  for (const double thickness : {2.5, 3.0, 4.0, 4.8}) {
    const std::vector<double> weights = spreadingWeights(SliceProfile::Box, thickness);
    double sum = 0;
    for (std::size_t n = 0; n < weights.size(); ++n) {
      sum += weights[n];
      EXPECT_NEAR(weights[n], weights[weights.size() - 1 - n], 1e-9) << thickness;
    }
    EXPECT_NEAR(sum, 1, 1e-9) << thickness;
  }
  for (const double w : spreadingWeights(SliceProfile::Box, 3))
    EXPECT_NEAR(w, 1. / 3, 1e-9);
}

TEST(BackProjection, OfOverlappingSlicesBringsDetailBack) {
  const Volume truth = phantom(grid(40, 40, 40));
  const auto mask = bodyMask(truth);
  for (const double thickness : {3.0, 5.0}) {
    Stack stack;
    stack.image = truth;
    stack.thickness = thickness;
    stack.image.voxels = projectToStack(truth, stack, pool);
    Volume volume = stack.image;
    const double before = pooledPsnr(volume.voxels, truth.voxels, mask, 200);
    EXPECT_LT(backProject(volume, {&stack, 1}, {}, pool), 0.5 * residual(stack.image, {&stack, 1}));
    EXPECT_GT(pooledPsnr(volume.voxels, truth.voxels, mask, 200), before + 2) << thickness;
  }
}

TEST(BackProjection, StopRequestCancels) {
  const Volume truth = randomVolume(grid(8, 8, 8), 0, 1);
  const std::vector<Stack> stacks{simulateThickStack(truth, 2, 4)};
  std::stop_source source;
  source.request_stop();
  BackProjectionSettings settings;
  settings.stop = source.get_token();
  EXPECT_THROW(backProjectionBaseline(stacks, truth.geometry, settings), Error);
}
