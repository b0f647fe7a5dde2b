#include "Core/Uncertainty/SimulatedGrids.h"

#include "TestVolumes.h"

#include <gtest/gtest.h>

namespace innergs {
namespace {

using testing::grid;

/// 5 mm slices across a cube of 96 voxels and beyond; slice k is shifted by k / 10 mm.
Stack movedScan() {
  Stack stack;
  stack.image.geometry = grid(150, 140, 30, {1, 1, 5}, {-20, -10, -25});
  stack.thickness = 4;
  for (int k = 0; k < 30; ++k)
    stack.poses.push_back({Mat3{}, Vec3{0.1 * k, 0, 0}});
  return stack;
}

TEST(SimulatedGrids, TakeTheirSlicesPosesWhereAsked) {
  const std::vector<Stack> scans{movedScan()};
  const GridGeometry cube = simulationGrid(scans, {47.5, 47.5, 47.5});
  EXPECT_EQ(cube.size, (std::array<std::int64_t, 3>{96, 96, 96}));
  const Stack still = simulatedGrids(scans, cube).front(), moved = simulatedGrids(scans, cube, true).front();
  EXPECT_TRUE(still.poses.empty());
  EXPECT_EQ(moved.image.geometry, still.image.geometry);
  EXPECT_EQ(moved.thickness, 4);
  ASSERT_EQ(static_cast<std::int64_t>(moved.poses.size()), moved.image.geometry.size[2]);
  const Vec3 first = scans[0].image.geometry.indexToWorld()({0, 0, 5}); // z = 0
  EXPECT_NEAR(moved.image.geometry.origin[2], first[2], 1e-9);
  for (std::size_t k = 0; k < moved.poses.size(); ++k)
    EXPECT_EQ(moved.poses[k], scans[0].poses[k + 5]) << k;
}

} // namespace
} // namespace innergs
