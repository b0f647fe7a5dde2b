#include "Core/Image/Volume.h"

#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

TEST(Volume, SampleLinearIsExactOnARampAndClampedOutside) {
  const Volume v = volumeOf(grid(5, 4, 3), [](auto i, auto j, auto k) { return i + 10.0 * j + 100.0 * k; });
  EXPECT_NEAR(sampleLinear(v, {1.25, 2.5, 1.75}), 1.25 + 25 + 175, 1e-4);
  EXPECT_FLOAT_EQ(sampleLinear(v, {4, 3, 2}), 234);
  EXPECT_FLOAT_EQ(sampleLinear(v, {-3, 0, 0}), 0);
  EXPECT_FLOAT_EQ(sampleLinear(v, {9, 9, 9}), 234);
}

TEST(Volume, WithSliceAxisKeepsEveryVoxelsPatientPosition) {
  const Volume v = randomVolume(grid(4, 5, 6, {1, 2, 3}, {7, -8, 9}, obliqueDirection(0.6, true)), 0, 1);
  for (int axis = 0; axis < 3; ++axis) {
    const Volume moved = withSliceAxis(v, axis);
    EXPECT_EQ(moved.geometry.size[2], v.geometry.size[axis]);
    const Affine3 toOriginal = inverse(v.geometry.indexToWorld()) * moved.geometry.indexToWorld();
    std::size_t at = 0;
    for (std::int64_t k = 0; k < moved.geometry.size[2]; ++k)
      for (std::int64_t j = 0; j < moved.geometry.size[1]; ++j)
        for (std::int64_t i = 0; i < moved.geometry.size[0]; ++i, ++at) {
          const Vec3 x = toOriginal({double(i), double(j), double(k)});
          for (double c : x)
            ASSERT_NEAR(c, std::round(c), 1e-9);
          const auto p = static_cast<std::size_t>(std::llround(x[0]) +
                                                  4 * (std::llround(x[1]) + 5 * std::llround(x[2])));
          ASSERT_EQ(moved.voxels[at], v.voxels[p]);
        }
  }
}

TEST(Volume, ResampleMaskGoesThroughPatientSpace) {
  Mask mask{grid(6, 6, 6, {2, 2, 2}, {0, 0, 0}), std::vector<std::uint8_t>(216, 0)};
  mask.voxels[2 + 6 * (3 + 6 * 4)] = 1; // covers 3…5, 5…7, 7…9 mm
  const GridGeometry fine = grid(12, 12, 12, {1, 1, 1}, {12, 12, 12}, [] {
    Mat3 flipped = diagonal({-1, -1, -1});
    return flipped;
  }());
  const auto result = resampleMask(mask, fine);
  std::size_t inside = 0;
  for (std::int64_t k = 0; k < 12; ++k)
    for (std::int64_t j = 0; j < 12; ++j)
      for (std::int64_t i = 0; i < 12; ++i) {
        const Vec3 x = fine.indexToWorld()({double(i), double(j), double(k)});
        const bool strictly = std::abs(x[0] - 4) < 1 && std::abs(x[1] - 6) < 1 && std::abs(x[2] - 8) < 1;
        const bool loosely = std::abs(x[0] - 4) <= 1 && std::abs(x[1] - 6) <= 1 && std::abs(x[2] - 8) <= 1;
        const bool in = result[static_cast<std::size_t>(i + 12 * (j + 12 * k))] != 0;
        EXPECT_TRUE(in || !strictly);
        EXPECT_TRUE(loosely || !in);
        inside += in;
      }
  EXPECT_EQ(inside, 8u); // ties go one way: each 2 mm voxel owns two of the 1 mm ones per axis
  GridGeometry away = fine;
  away.origin = {500, 500, 500};
  for (std::uint8_t m : resampleMask(mask, away))
    ASSERT_EQ(m, 0);
}
