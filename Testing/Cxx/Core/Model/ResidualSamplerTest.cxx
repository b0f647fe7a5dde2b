#include "Core/Model/ResidualSampler.h"

#include "TestVolumes.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

TEST(ResidualSampler, RowsAreItsPointsOnVoxelsAndBetween) {
  GaussianField field;
  field.residual = randomVolume(grid(9, 8, 7, {1.5, 1.3, 1.4}, {3, 4, 5}, obliqueDirection(0.3)), -1, 1, 8);
  const Affine3 own = field.residual.geometry.indexToWorld();
  Affine3 flipped = own; // index 0 is its voxel 10, 2, 0 and each step goes back by two
  flipped.offset = own({10, 2, 0});
  for (int r = 0; r < 3; ++r)
    flipped.linear[r][0] *= -2;
  for (const Affine3& map : {own, flipped, Affine3{obliqueDirection(-0.2), {-1, 2, 1}}}) {
    const ResidualSampler sampler(field, map);
    int different = 0;
    for (int z = -1; z < 8; ++z)
      for (int y = -1; y < 9; ++y) {
        std::vector<float> row(14, 1);
        sampler.add(y, z, 1, 14, row.data());
        EXPECT_EQ(row[0], 1);
        for (int x = 1; x < 14; ++x) {
          const Vec3 index{double(x), double(y), double(z)};
          ASSERT_NEAR(row[x], 1 + sampler(index), 5e-6) << x << ' ' << y << ' ' << z;
          different += row[x] != 1;
        }
      }
    EXPECT_GT(different, 50);
  }
}

TEST(ResidualSampler, RefusesAnInstructionSetThatDoesNotExist) {
  EXPECT_EQ(test::codeOf([] { ResidualSampler(GaussianField(), {}, "MMX"); }), ErrorCode::InvalidArgument);
}
