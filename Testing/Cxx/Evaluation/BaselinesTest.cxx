#include "Evaluation/Baselines.h"

#include "Core/Base/Error.h"
#include "Core/Image/Simulate.h"
#include "Evaluation/ItkInterpolation.h"
#include "Evaluation/SeparableResample.h"

#include "../Core/TestVolumes.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr Interpolation allKinds[] = {Interpolation::Linear, Interpolation::Cubic, Interpolation::Lanczos};

double ramp(const Vec3& x) {
  return 3 * x[0] - 2 * x[1] + 0.7 * x[2] + 40;
}

Stack stackOf(Volume image) {
  Stack stack;
  stack.image = std::move(image);
  return stack;
}

// True `margin` voxels inside the stack's outermost voxel centres.
bool wellInside(const GridGeometry& image, const Vec3& world, double margin) {
  const Vec3 index = inverse(image.indexToWorld())(world);
  for (int axis = 0; axis < 3; ++axis)
    if (index[axis] < margin || index[axis] > double(image.size[axis] - 1) - margin) return false;
  return true;
}

} // namespace

// Boundary effects of the cubic spline decay by 0.27 per voxel; Lanczos is exact only for constants.
TEST(Baselines, ReproduceRampsThroughAnyPairOfGrids) {
  const GridGeometry oblique = grid(30, 28, 26, {1, 1.2, 1.5}, {-20, 5, 60}, obliqueDirection(0.6));
  const GridGeometry leftHanded = grid(30, 28, 26, {1, 1.2, 1.5}, {-20, 5, 60}, obliqueDirection(0.6, true));
  for (const GridGeometry& image : {oblique, leftHanded}) {
    GridGeometry turned = grid(9, 8, 7, {1.1, 0.9, 1.3}, {0, 0, 0}, obliqueDirection(-0.3, true));
    turned.origin = image.centre() - (turned.centre() - turned.origin);
    GridGeometry along = withSpacing(image, {0.7, 0.8, 0.6});
    for (int r = 0; r < 3; ++r) { // flip one axis, swap two: still aligned
      std::swap(along.direction[r][0], along.direction[r][1]);
      along.direction[r][2] = -along.direction[r][2];
    }
    std::swap(along.size[0], along.size[1]);
    std::swap(along.spacing[0], along.spacing[1]);
    along.origin = {0, 0, 0};
    along.origin = image.centre() - along.centre();
    ASSERT_FALSE(alignedAxes(image, turned));
    ASSERT_TRUE(alignedAxes(image, along));
    const Stack stack = stackOf(volumeInSpace(image, ramp));
    for (const GridGeometry& target : {turned, along})
      for (const Interpolation kind : {Interpolation::Linear, Interpolation::Cubic}) {
        const Upsampled result = upsample(stack, target, kind);
        const Affine3 toWorld = target.indexToWorld();
        std::size_t at = 0, compared = 0;
        for (std::int64_t k = 0; k < target.size[2]; ++k)
          for (std::int64_t j = 0; j < target.size[1]; ++j)
            for (std::int64_t i = 0; i < target.size[0]; ++i, ++at) {
              const Vec3 x = toWorld({double(i), double(j), double(k)});
              if (!wellInside(image, x, kind == Interpolation::Linear ? 0 : 9)) continue;
              ++compared;
              ASSERT_EQ(result.weight[at], 1);
              ASSERT_NEAR(result.volume.voxels[at], ramp(x), 2e-3);
            }
        EXPECT_GT(compared, 200u);
      }
  }
}

TEST(Baselines, ConstantsStayConstantEverywhere) {
  const GridGeometry image = grid(12, 11, 10, {1, 1, 3}, {0, 0, 0}, obliqueDirection(0.2));
  const Stack stack = stackOf(volumeOf(image, [](auto, auto, auto) { return 123; }));
  for (const GridGeometry& target :
       {withSpacing(image, {1, 1, 1}), grid(12, 11, 10, {1, 1, 3}, {3, 2, 1}, obliqueDirection(0.9))})
    for (const Interpolation kind : allKinds)
      for (float v : upsample(stack, target, kind).volume.voxels)
        ASSERT_NEAR(v, 123, 1e-2);
}

// The fast separable method must match ITK.
TEST(Baselines, TwoSlicesAcrossAnObliqueGrid) {
  const GridGeometry image = grid(12, 11, 2, {1, 1, 3});
  const Stack stack = stackOf(volumeInSpace(image, [](const Vec3&) { return 7.0; }));
  const GridGeometry oblique = grid(12, 11, 4, {1, 1, 1}, {0, 0, 0}, obliqueDirection(0.3));
  for (const Interpolation kind : allKinds)
    for (const float v : upsample(stack, oblique, kind).volume.voxels)
      ASSERT_NEAR(v, 7, 1e-4);
}

TEST(Baselines, SeparableResamplingAgreesWithItk) {
  const GridGeometry image = grid(14, 13, 9, {1, 1.5, 4}, {3, 4, 5}, obliqueDirection(0.4, true));
  const Volume v = randomVolume(image, 0, 100);
  const GridGeometry target = withSpacing(image, {0.7, 1.1, 1});
  ThreadPool pool(2);
  for (const Interpolation kind : allKinds) {
    const auto ours = resampleAligned(v, target, *alignedAxes(image, target), kind, pool);
    const auto itk = resampleWithItk(v, target, kind, pool);
    ASSERT_EQ(ours.size(), itk.size());
    for (std::size_t p = 0; p < ours.size(); ++p)
      ASSERT_NEAR(ours[p], itk[p], 5e-3) << "kind " << int(kind);
  }
}

TEST(Baselines, OutsideTakesTheNearestEdgeWithoutWeight) {
  const GridGeometry image = grid(4, 4, 4);
  const Stack stack = stackOf(volumeOf(image, [](auto i, auto, auto) { return 10.0 * double(i); }));
  const GridGeometry wide = grid(10, 4, 4, {1, 1, 1}, {-3, 0, 0});
  for (const Interpolation kind : allKinds) {
    const Upsampled result = upsample(stack, wide, kind);
    EXPECT_NEAR(result.volume.voxels[0], 0, 1e-4);
    EXPECT_NEAR(result.volume.voxels[9], 30, 1e-4);
    EXPECT_EQ(result.weight[2], 0);
    EXPECT_EQ(result.weight[3], 1);
    EXPECT_EQ(result.weight[6], 1);
    EXPECT_EQ(result.weight[7], 0);
  }
}

TEST(Baselines, UnobservedAndNonFiniteVoxelsTakeNoPart) {
  const GridGeometry image = grid(8, 8, 8);
  Stack stack = stackOf(volumeOf(image, [](auto, auto, auto) { return 50; }));
  stack.observed.assign(512, 1);
  for (std::size_t p = 0; p < 64; ++p) {
    stack.image.voxels[64 * 3 + p] = 1e9f; // a whole slice, held out
    stack.observed[64 * 3 + p] = 0;
  }
  stack.image.voxels[64 * 6 + 9] = std::numeric_limits<float>::quiet_NaN();
  for (const Interpolation kind : allKinds) {
    const Upsampled result = upsample(stack, withSpacing(image, {0.5, 0.5, 0.5}), kind);
    for (float v : result.volume.voxels)
      ASSERT_NEAR(v, 50, 1e-3);
  }
  const Upsampled same = upsample(stack, image, Interpolation::Linear);
  EXPECT_EQ(same.weight[64 * 3 + 5], 0);
  EXPECT_EQ(same.weight[64 * 6 + 9], 0);
  EXPECT_EQ(same.weight[64 * 6 + 10], 1);
}

TEST(Baselines, AverageUsesEachStackWhereItIs) {
  const GridGeometry target = grid(8, 4, 4);
  const std::vector<Stack> stacks = {
      stackOf(volumeOf(grid(5, 4, 4), [](auto, auto, auto) { return 10; })),
      stackOf(volumeOf(grid(5, 4, 4, {1, 1, 1}, {3, 0, 0}), [](auto, auto, auto) { return 20; }))};
  const Volume average = averageUpsampled(stacks, target, Interpolation::Linear);
  const float expected[8] = {10, 10, 10, 15, 15, 20, 20, 20};
  for (int i = 0; i < 8; ++i)
    EXPECT_NEAR(average.voxels[i], expected[i], 1e-4) << i;
}

TEST(Baselines, ThreadsDoNotChangeTheResult) {
  const GridGeometry image = grid(20, 18, 7, {1, 1, 4});
  const Stack stack = stackOf(randomVolume(image, 0, 1));
  for (const GridGeometry& target :
       {withSpacing(image, {1, 1, 1}), grid(9, 9, 9, {1, 1, 1}, {2, 2, 2}, obliqueDirection(0.3))})
    for (const Interpolation kind : allKinds)
      EXPECT_EQ(upsample(stack, target, kind, 1).volume.voxels,
                upsample(stack, target, kind, 3).volume.voxels);
}

TEST(Baselines, RefusesSlicePoses) {
  Stack stack = stackOf(randomVolume(grid(4, 4, 4), 0, 1));
  stack.poses.assign(4, Affine3{});
  EXPECT_THROW(upsample(stack, stack.image.geometry, Interpolation::Linear), Error);
}
