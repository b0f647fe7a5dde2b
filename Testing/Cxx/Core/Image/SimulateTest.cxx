#include "Core/Image/Simulate.h"

#include "Core/Base/Error.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>
#include <numeric>

using namespace innergs;
using namespace innergs::testing;

namespace {

double mean(const std::vector<float>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / double(v.size());
}

} // namespace

TEST(Simulate, ThickSlicesKeepTheMean) {
  const Volume v = randomVolume(grid(8, 12, 16), 0, 100);
  for (int axis = 0; axis < 3; ++axis) {
    const Stack stack = simulateThickStack(v, axis, 4);
    EXPECT_EQ(stack.image.geometry.size[2], v.geometry.size[axis] / 4);
    EXPECT_NEAR(mean(stack.image.voxels), mean(v.voxels), 1e-4);
    EXPECT_NO_THROW(checkStack(stack));
  }
}

// A slice of a patient-space ramp has the ramp's value at the slice's centre, for any axis and orientation.
TEST(Simulate, SlicesSitAtTheCentreOfTheirBoxInPatientSpace) {
  for (const bool leftHanded : {false, true}) {
    const GridGeometry g = grid(9, 10, 11, {1, 1.5, 2}, {5, -40, 12}, obliqueDirection(0.5, leftHanded));
    const Volume v = volumeInSpace(g, [](const Vec3& x) { return 2 * x[0] - 3 * x[1] + 0.5 * x[2]; });
    for (int axis = 0; axis < 3; ++axis) {
      const Stack stack = simulateThickStack(v, axis, 3);
      EXPECT_NEAR(stack.image.geometry.spacing[2], 3 * g.spacing[axis], 1e-12);
      EXPECT_NEAR(stack.thickness, 3 * g.spacing[axis], 1e-12);
      EXPECT_EQ(stack.profile, SliceProfile::Box);
      EXPECT_NEAR(std::abs(dot(column(stack.image.geometry.direction, 2), column(g.direction, axis))), 1,
                  1e-12);
      const Volume expected =
          volumeInSpace(stack.image.geometry, [](const Vec3& x) { return 2 * x[0] - 3 * x[1] + 0.5 * x[2]; });
      for (std::size_t p = 0; p < expected.voxels.size(); ++p)
        ASSERT_NEAR(stack.image.voxels[p], expected.voxels[p], 1e-3);
    }
  }
}

TEST(Simulate, KeepEveryKeepsTheVoxelsAndTheirPlaces) {
  const GridGeometry g = grid(5, 6, 10, {1, 1.5, 2}, {5, -40, 12}, obliqueDirection(0.5, true));
  const Volume v = volumeInSpace(g, [](const Vec3& x) { return 2 * x[0] - 3 * x[1] + 0.5 * x[2]; });
  for (int axis = 0; axis < 3; ++axis) {
    const Stack stack = keepEvery(v, axis, 3);
    EXPECT_EQ(stack.profile, SliceProfile::Point);
    EXPECT_EQ(stack.image.geometry.size[2], (g.size[axis] + 2) / 3);
    const Volume expected =
        volumeInSpace(stack.image.geometry, [](const Vec3& x) { return 2 * x[0] - 3 * x[1] + 0.5 * x[2]; });
    for (std::size_t p = 0; p < expected.voxels.size(); ++p)
      ASSERT_NEAR(stack.image.voxels[p], expected.voxels[p], 1e-4);
  }
}

TEST(Simulate, NoiseHasTheAskedDeviationAndDependsOnTheSeedOnly) {
  const Volume v = volumeOf(grid(40, 40, 40), [](auto, auto, auto) { return 100; });
  const Stack a = simulateThickStack(v, 2, 2, 5, 7), b = simulateThickStack(v, 2, 2, 5, 7);
  EXPECT_EQ(a.image.voxels, b.image.voxels);
  EXPECT_NE(a.image.voxels, simulateThickStack(v, 2, 2, 5, 8).image.voxels);
  double squares = 0;
  for (float x : a.image.voxels)
    squares += (x - 100.0) * (x - 100.0);
  EXPECT_NEAR(std::sqrt(squares / double(a.image.voxels.size())), 5, 0.1);
  EXPECT_NEAR(mean(a.image.voxels), 100, 0.1);
}

TEST(Simulate, RefusesImpossibleThickness) {
  const Volume v = randomVolume(grid(4, 4, 4), 0, 1);
  EXPECT_THROW(simulateThickStack(v, 2, 0), Error);
  EXPECT_THROW(simulateThickStack(v, 2, 5), Error);
  EXPECT_THROW(simulateThickStack(v, 3, 2), Error);
  EXPECT_THROW(simulateThickStack(v, 2, 2, -1), Error);
  EXPECT_THROW(keepEvery(v, 0, 0), Error);
}
