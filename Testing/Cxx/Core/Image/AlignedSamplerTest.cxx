#include "Core/Image/AlignedSampler.h"
#include "Core/Image/Volume.h"

#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

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

TEST(AlignedSampler, FindsParallelAxes) {
  const GridGeometry volume = grid(9, 8, 7, {1, 1.5, 2}, {3, 2, 1}, obliqueDirection(0.5));
  const Affine3 toIndex = inverse(volume.indexToWorld());
  for (const std::array<int, 3>& axes : {std::array{0, 1, 2}, {2, 0, 1}, {1, 0, 2}}) {
    const GridGeometry points = pointsOver(volume, axes, {-1, 0.5, 1}, {2, 0.4, 3});
    EXPECT_EQ(parallelAxes(points.size, toIndex * points.indexToWorld()), axes);
  }
}

TEST(AlignedSampler, LeavesOtherGridsAlone) {
  const GridGeometry volume = grid(6, 8, 7),
                     turned = grid(6, 8, 7, {1, 1, 1}, {0, 0, 0}, obliqueDirection(0.01));
  const Affine3 map = inverse(volume.indexToWorld()) * turned.indexToWorld();
  EXPECT_FALSE(AlignedSampler::between(turned.size, map, volume));
  EXPECT_FALSE(parallelAxes(turned.size, map));
}
