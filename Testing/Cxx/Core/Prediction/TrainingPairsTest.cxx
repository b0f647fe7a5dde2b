#include "Core/Prediction/TrainingPairs.h"
#include "Core/Image/Simulate.h"
#include "SpherePhantom.h"

#include <gtest/gtest.h>
#include <limits>

namespace innergs {
namespace {

using testing::spherePhantom;

TEST(TrainingPairs, DegradeAsTheSimulationOfThickSlicesDoes) {
  const Volume truth = spherePhantom(40, 24);
  const Stack across = simulateThickStack(truth, 0, 4); // the rows of axis 0 averaged in groups of four
  Stack stack;                                          // equally thick slices, to train on in-plane
  stack.image = truth;
  stack.image.geometry.spacing[2] = 4;
  stack.thickness = 4;
  GridGeometry thin = stack.image.geometry;
  thin.spacing[2] = 1;
  thin.origin[2] = -1.5;
  const SliceSampling sampling = sliceSampling(stack, thin, 4);
  EXPECT_EQ(sampling.firstPhase, 0);
  ThreadPool pool(2);
  const FilledImage filled = filledImage(stack);
  const std::vector<std::uint8_t> body(truth.voxels.size(), 1);
  TrainingPlanesRequest request;
  request.axes = {true, false};
  const TrainingPlanes planes = trainingPlanes(filled, body, sampling, request, pool);
  ASSERT_EQ(planes.learning.size(), 20u); // slice 3 and every sixth from there are held out
  ASSERT_EQ(planes.measuring.size(), 4u);
  Random random(1);
  TrainingPair pair;
  makePair(planes.learning[0], {}, sampling, 10, 40, 0, random, pair);
  for (int s = 0; s < 10; ++s)
    for (int c = 0; c < 40; ++c) { // slice 0 of the stack: K = 0, columns along J
      ASSERT_NEAR(
          pair.low[static_cast<std::size_t>(s) * 40 + c],
          across.image.voxels[static_cast<std::size_t>(c) + 40 * (0 + 24 * static_cast<std::size_t>(s))],
          1e-3);
      for (int q = 0; q < 4; ++q)
        ASSERT_EQ(pair.thin[(static_cast<std::size_t>(s) * 40 + c) * 4 + q],
                  truth.voxels[static_cast<std::size_t>(4 * s + q) + 40 * static_cast<std::size_t>(c)]);
    }
}

TEST(TrainingPairs, AReflectedPairIsThePairReflected) {
  const Volume truth = spherePhantom(40, 6);
  Stack stack;
  stack.image = truth;
  stack.image.geometry.spacing[2] = 4;
  GridGeometry thin = stack.image.geometry;
  thin.spacing[2] = 1;
  thin.origin[2] = -1.5;
  const SliceSampling sampling = sliceSampling(stack, thin, 4);
  ThreadPool pool(1);
  const TrainingPlanes planes = trainingPlanes(
      filledImage(stack), std::vector<std::uint8_t>(truth.voxels.size(), 1), sampling, {}, pool);
  Random random(1);
  TrainingPair pair, reflected;
  makePair(planes.learning[0], {0, 4, 3, false, false}, sampling, 8, 20, 0, random, pair);
  makePair(planes.learning[0], {0, 4, 3, true, true}, sampling, 8, 20, 0, random, reflected);
  for (int s = 0; s < 8; ++s)
    for (int c = 0; c < 20; ++c) {
      const std::size_t at = static_cast<std::size_t>(s) * 20 + c, mirrored = 8 * 20 - 1 - at;
      ASSERT_NEAR(reflected.low[mirrored], pair.low[at], 1e-4);
      for (int q = 0; q < 4; ++q)
        ASSERT_EQ(reflected.thin[mirrored * 4 + 3 - q], pair.thin[at * 4 + q]);
    }
}

TEST(TrainingPairs, UnknownVoxelsAreFilledFromKnownOnesAndCountNowhere) {
  Stack stack;
  stack.image = spherePhantom(48, 8);
  stack.image.geometry.spacing[2] = 3;
  stack.observed.assign(stack.image.voxels.size(), 1);
  const std::size_t unknown = 24 + 48 * (24 + 48 * 2);
  stack.observed[unknown] = 0;
  stack.image.voxels[unknown] = 1e6f;
  stack.image.voxels[unknown + 1] = std::numeric_limits<float>::infinity();
  const FilledImage filled = filledImage(stack);
  ASSERT_EQ(filled.known.size(), stack.image.voxels.size());
  EXPECT_EQ(std::count(filled.known.begin(), filled.known.end(), 0), 2);
  for (const float v : filled.image.voxels)
    ASSERT_LT(v, 1000);
  GridGeometry thin = stack.image.geometry;
  thin.spacing[2] = 1;
  thin.origin[2] = -1;
  const SliceSampling sampling = sliceSampling(stack, thin, 3);
  ThreadPool pool(1);
  TrainingPlanesRequest request;
  request.axes = {true, false};
  const TrainingPlanes planes = trainingPlanes(
      filled, std::vector<std::uint8_t>(stack.image.voxels.size(), 1), sampling, request, pool);
  const TrainingPlane& plane = planes.learning[2]; // slice 2: rows along I, columns along J
  EXPECT_EQ(plane.inside[24 * 48 + 24], 0);
  EXPECT_EQ(plane.inside[20 * 48 + 22], 0); // its patch would include it
  EXPECT_EQ(plane.inside[20 * 48 + 36], 1);
  EXPECT_EQ(planes.learning[1].inside[24 * 48 + 24], 1);
}

} // namespace
} // namespace innergs
