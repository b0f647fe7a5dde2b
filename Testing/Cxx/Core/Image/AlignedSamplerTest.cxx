#include "Core/Image/AlignedSampler.h"
#include "Core/Image/Volume.h"

#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// The points' grid in the frame of the volume's: axes permuted, reversed where asked, and shifted.
GridGeometry pointsOver(const GridGeometry& volume, const std::array<int, 3>& axes, const Vec3& step,
                        const Vec3& origin) {
  GridGeometry points;
  points.size = {9, 11, 7};
  for (int b = 0; b < 3; ++b) {
    points.spacing[b] = std::abs(step[b]) * volume.spacing[axes[b]];
    for (int row = 0; row < 3; ++row)
      points.direction[row][b] = std::copysign(1.0, step[b]) * volume.direction[row][axes[b]];
  }
  points.origin = volume.indexToWorld()(origin);
  return points;
}

} // namespace

TEST(AlignedSampler, AgreesWithSampleInside) {
  const Volume volume =
      randomVolume(grid(6, 8, 7, {1, 1.5, 2}, {3, 2, 1}, obliqueDirection(0.5, true)), -50, 50);
  struct Case {
    std::array<int, 3> axes;
    Vec3 step, origin; // voxels of the volume
  };
  for (const Case& c :
       {Case{{0, 1, 2}, {1, 1, 1}, {0, 0, 0}}, Case{{0, 1, 2}, {1, 1, 0.25}, {-2, 3, -0.375}},
        Case{{0, 1, 2}, {0.7, 0.4, 1.3}, {-1.1, 0.6, 0.2}}, Case{{2, 0, 1}, {1, -1, 0.5}, {5, 0, 6}},
        Case{{1, 2, 0}, {-0.9, 0.8, 0.3}, {2, 6.2, -0.4}}}) {
    const GridGeometry points = pointsOver(volume.geometry, c.axes, c.step, c.origin);
    const Affine3 map = inverse(volume.geometry.indexToWorld()) * points.indexToWorld();
    const auto sampler = AlignedSampler::between(points.size, map, volume.geometry);
    ASSERT_TRUE(sampler);
    int inside = 0;
    for (std::int64_t k = 0; k < points.size[2]; ++k)
      for (std::int64_t j = 0; j < points.size[1]; ++j) {
        const float outside = std::numeric_limits<float>::quiet_NaN();
        std::vector<float> row(static_cast<std::size_t>(points.size[0]), outside);
        sampler->row(volume.voxels.data(), j, k, [&](std::int64_t i, float value) { row[i] = value; });
        for (std::int64_t i = 0; i < points.size[0]; ++i) {
          const Vec3 at{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
          float expected = outside;
          if (sampleInside(volume.geometry, volume.voxels.data(), map(at), expected)) {
            ASSERT_NEAR(row[i], expected, 1e-3);
            ++inside;
          } else {
            ASSERT_TRUE(std::isnan(row[i]));
          }
        }
      }
    EXPECT_GT(inside, 30);
    EXPECT_LT(inside, points.voxelCount());
  }
}

TEST(AlignedSampler, TellsVoxelsFromPointsBetweenThem) {
  const GridGeometry volume = grid(9, 8, 7, {1, 1.5, 2}, {3, 2, 1}, obliqueDirection(0.5));
  const auto onVoxels = [&](const Vec3& step, const Vec3& origin) {
    const GridGeometry points = pointsOver(volume, {2, 0, 1}, step, origin);
    return AlignedSampler::between(points.size, inverse(volume.indexToWorld()) * points.indexToWorld(),
                                   volume)
        ->onVoxels();
  };
  EXPECT_TRUE(onVoxels({1, 1, 1}, {0, 0, 0}));
  EXPECT_TRUE(onVoxels({-1, 2, 1}, {-3, 2, 6}));
  EXPECT_FALSE(onVoxels({1, 1, 1}, {0, 0.4, 0}));
  EXPECT_FALSE(onVoxels({1, 0.5, 1}, {0, 0, 0}));
}

TEST(AlignedSampler, LeavesOtherGridsAlone) {
  const GridGeometry volume = grid(6, 8, 7),
                     turned = grid(6, 8, 7, {1, 1, 1}, {0, 0, 0}, obliqueDirection(0.01));
  const Affine3 map = inverse(volume.indexToWorld()) * turned.indexToWorld();
  EXPECT_FALSE(AlignedSampler::between(turned.size, map, volume));
}
