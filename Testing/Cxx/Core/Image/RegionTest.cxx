#include "Core/Image/Region.h"
#include "Core/Base/Error.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace innergs {
namespace {

Stack ramp() {
  Stack stack;
  stack.image.geometry.size = {20, 16, 10};
  stack.image.geometry.spacing = {1, 1, 3};
  stack.image.geometry.origin = {100, -50, 7};
  stack.image.geometry.direction.m = {{{0, -1, 0}, {1, 0, 0}, {0, 0, -1}}};
  for (std::int64_t n = 0; n < stack.image.geometry.voxelCount(); ++n)
    stack.image.voxels.push_back(static_cast<float>(n));
  return stack;
}

// A box around some voxels' centres, slightly larger.
Region around(const Affine3& toWorld, const Vec3& a, const Vec3& b) {
  const Vec3 p = toWorld(a), q = toWorld(b);
  Region region;
  for (int axis = 0; axis < 3; ++axis) {
    region.min[axis] = std::min(p[axis], q[axis]) - 0.1;
    region.max[axis] = std::max(p[axis], q[axis]) + 0.1;
  }
  return region;
}

TEST(RegionTest, KeepsVoxelsInTheirPlace) {
  const Stack whole = ramp();
  const GridGeometry& g = whole.image.geometry;
  const Stack part = cropped(whole, around(g.indexToWorld(), {3, 4, 2}, {9, 5, 6}));
  EXPECT_EQ(part.image.geometry.size, (std::array<std::int64_t, 3>{7, 2, 5}));
  const Vec3 first = g.indexToWorld()({3, 4, 2});
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(part.image.geometry.origin[axis], first[axis], 1e-9);
  ASSERT_EQ(part.image.voxels.size(), 70u);
  EXPECT_EQ(part.image.voxels.front(), 3 + 20 * (4 + 16 * 2));
  EXPECT_EQ(part.image.voxels.back(), 9 + 20 * (5 + 16 * 6));
  EXPECT_TRUE(sameGrid(part.image.geometry, cropped(g, around(g.indexToWorld(), {3, 4, 2}, {9, 5, 6}))));
}

TEST(RegionTest, MarginGrowsUpToTheEdges) {
  const GridGeometry g = ramp().image.geometry;
  const Region region = around(g.indexToWorld(), {3, 4, 2}, {9, 5, 6});
  EXPECT_EQ(cropped(g, region, 2).size, (std::array<std::int64_t, 3>{11, 6, 7}));
  EXPECT_EQ(cropped(g, region, 1000), g);
}

TEST(RegionTest, FollowsSlicePosesAndKeepsTheirData) {
  Stack whole = ramp();
  whole.poses.resize(10);
  whole.times.resize(10);
  whole.observed.assign(whole.image.voxels.size(), 1);
  for (int k = 0; k < 10; ++k) {
    whole.times[k] = k;
    whole.poses[k].offset = {0, 0, 30}; // ten slices up, against the K direction
  }
  const Affine3 placed = whole.poses[0] * whole.image.geometry.indexToWorld();
  const Stack part = cropped(whole, around(placed, {0, 0, 4}, {19, 15, 6}));
  EXPECT_EQ(part.image.geometry.size, (std::array<std::int64_t, 3>{20, 16, 3}));
  EXPECT_EQ(part.times, (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(part.poses.size(), 3u);
  EXPECT_EQ(part.observed.size(), part.image.voxels.size());
  EXPECT_EQ(part.image.voxels.front(), 20 * 16 * 4);
}

TEST(RegionTest, CutsTheBlockOfWhatIsNotZero) {
  const Volume whole = ramp().image;
  const auto at = [](std::int64_t i, std::int64_t j, std::int64_t k) { return i + 20 * (j + 16 * k); };
  Mask mask{whole.geometry, std::vector<std::uint8_t>(whole.voxels.size(), 0)};
  EXPECT_FALSE(filledBlock(mask.geometry.size, mask.voxels));
  for (const std::int64_t v : {at(3, 9, 4), at(12, 5, 4), at(7, 6, 8)})
    mask.voxels[v] = 1;
  const auto block = filledBlock(mask.geometry.size, mask.voxels);
  ASSERT_TRUE(block);
  EXPECT_EQ(block->first, (std::array<std::int64_t, 3>{3, 5, 4}));
  EXPECT_EQ(block->size, (std::array<std::int64_t, 3>{10, 5, 5}));
  const Volume part = cropped(whole, *block);
  EXPECT_EQ(part.geometry, cropped(whole.geometry, block->first, block->size));
  ASSERT_EQ(part.voxels.size(), 250u);
  EXPECT_EQ(part.voxels.front(), at(3, 5, 4));
  EXPECT_EQ(part.voxels.back(), at(12, 9, 8));
  const Mask cut = cropped(mask, *block);
  EXPECT_EQ(std::count(cut.voxels.begin(), cut.voxels.end(), 1), 3);
}

TEST(RegionTest, RefusesInvertedAndDistantRegions) {
  const Stack stack = ramp();
  EXPECT_THROW(cropped(stack, Region{{0, 0, 0}, {0, 1, 1}}), Error);
  EXPECT_THROW(cropped(stack.image.geometry, Region{{900, 0, 0}, {910, 10, 10}}), Error);
  EXPECT_THROW(cropped(stack, Region{{900, 0, 0}, {910, 10, 10}}), Error);
}

} // namespace
} // namespace innergs
