#include "Core/Fit/CoverUnreached.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

std::int64_t at(std::int64_t i, std::int64_t j, std::int64_t k) {
  return i + 12 * (j + 12 * k);
}

/// Four observed voxels of 100, 100, 60 and 0, the first of which has a Gaussian.
struct LostVoxels {
  Stack stack;
  GaussianField field;

  LostVoxels() {
    stack.image = volumeOf(grid(12, 12, 12), [](auto, auto, auto) { return 100; });
    stack.image.voxels[at(9, 8, 8)] = 60;
    stack.image.voxels[at(9, 9, 9)] = 0;
    stack.observed.assign(stack.image.voxels.size(), 0);
    for (const std::int64_t v : {at(2, 2, 2), at(8, 8, 8), at(9, 8, 8), at(9, 9, 9)})
      stack.observed[v] = 1;
    field.intensityScale = 100;
    field.domain = stack.image.geometry;
    Gaussian there{};
    for (int a = 0; a < 3; ++a) {
      there.mean[a] = 2;
      there.logScale[a] = std::log(0.5f);
    }
    there.quaternion[0] = 1;
    there.intensity = 1;
    field.gaussians = {there};
  }
  bool cover(std::int64_t most) { return coverUnreached(field, std::span(&stack, 1), most, {}); }
};

} // namespace

TEST(CoverUnreached, GivesEachLostVoxelItsValueAlone) {
  LostVoxels lost;
  EXPECT_TRUE(lost.cover(10));
  EXPECT_EQ(lost.field.size(), 3) << "the dark voxel needs none";
  const Volume now = render(lost.field, lost.stack.image.geometry);
  EXPECT_NEAR(now.voxels[at(8, 8, 8)], 100, 1);
  EXPECT_NEAR(now.voxels[at(9, 8, 8)], 60, 1);
  EXPECT_EQ(now.voxels[at(8, 9, 8)], 0);
  EXPECT_EQ(now.voxels[at(9, 9, 9)], 0);
  EXPECT_FALSE(lost.cover(10)) << "nothing is left to cover";
}

TEST(CoverUnreached, CoversTheStrongestFirst) {
  LostVoxels lost;
  EXPECT_TRUE(lost.cover(1));
  EXPECT_EQ(lost.field.size(), 2);
  const Volume now = render(lost.field, lost.stack.image.geometry);
  EXPECT_NEAR(now.voxels[at(8, 8, 8)], 100, 1);
  EXPECT_EQ(now.voxels[at(9, 8, 8)], 0);
}
