#include "Core/Prediction/AdjoiningScans.h"

#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

const GridGeometry kWhole = grid(16, 14, 20, {1, 1, 3}, {-30, 12, 5}, obliqueDirection(0.3));
constexpr std::int64_t kPlane = std::int64_t{16} * 14;

/// Slices [first, first + count) of a volume, as a scan.
Stack slab(const Volume& volume, std::int64_t first, std::int64_t count) {
  Stack stack;
  GridGeometry& g = stack.image.geometry = volume.geometry;
  g.origin = volume.geometry.indexToWorld()({0, 0, static_cast<double>(first)});
  g.size[2] = count;
  stack.image.voxels.assign(volume.voxels.begin() + first * kPlane,
                            volume.voxels.begin() + (first + count) * kPlane);
  return stack;
}

/// Linear in the patient's frame.
double ramp(const Vec3& x) {
  return 100 + 2 * x[0] - 3 * x[1] + 1.5 * x[2];
}

Volume constantOn(const GridGeometry& geometry, float value) {
  return {geometry, std::vector<float>(static_cast<std::size_t>(geometry.voxelCount()), value)};
}

TEST(Continued, HasTheSlicesOfItsNeighbours) {
  const Volume whole = phantom(kWhole);
  const std::vector<Stack> scans{slab(whole, 0, 8), slab(whole, 7, 6), slab(whole, 13, 7)};
  ThreadPool pool(2);
  const Stack middle = continued(scans, 1, 3, pool), first = continued(scans, 0, 3, pool);
  EXPECT_EQ(middle.image.geometry.size[2], 12);
  EXPECT_LT(norm(middle.image.geometry.origin - kWhole.indexToWorld()({0, 0, 4})), 1e-9);
  for (std::int64_t v = 0; v < 12 * kPlane; ++v)
    ASSERT_NEAR(middle.image.voxels[v], whole.voxels[4 * kPlane + v], 1e-3);
  EXPECT_EQ(first.image.geometry.size[2], 11) << "nothing lies before it";
  EXPECT_EQ(middle.thickness, 3);
  EXPECT_EQ(continued({scans.data(), 1}, 0, 3, pool).image.voxels, scans[0].image.voxels);
}

TEST(Continued, ReachesOverAMissingSliceAndNotBeyondWhatIsObserved) {
  const Volume whole = phantom(kWhole);
  std::vector<Stack> scans{slab(whole, 0, 8), slab(whole, 9, 8)};
  ThreadPool pool(2);
  const Stack over = continued(scans, 0, 3, pool);
  ASSERT_EQ(over.image.geometry.size[2], 11);
  EXPECT_TRUE(std::isnan(over.image.voxels[8 * kPlane]));
  EXPECT_NEAR(over.image.voxels[9 * kPlane], whole.voxels[9 * kPlane], 1e-3);
  scans[1].observed.assign(scans[1].image.voxels.size(), 1);
  std::fill_n(scans[1].observed.begin(), 2 * kPlane, 0); // held out
  std::fill_n(scans[1].image.voxels.begin(), 2 * kPlane, 1e5F);
  EXPECT_EQ(continued(scans, 0, 3, pool).image.geometry.size[2], 8);
  std::fill_n(scans[1].observed.begin(), 2 * kPlane - kPlane / 3, 1); // most of the second slice is known
  scans[0].observed.assign(scans[0].image.voxels.size(), 1);
  scans[0].observed[5] = 0;
  const Stack most = continued(scans, 0, 3, pool);
  ASSERT_EQ(most.image.geometry.size[2], 11);
  EXPECT_EQ(most.observed[5], 0);
  EXPECT_EQ(most.observed.size(), most.image.voxels.size());
  EXPECT_TRUE(std::isnan(most.image.voxels[10 * kPlane - 1]));
}

TEST(JoinedVolumes, KeepPlacesOfTurnedScans) {
  const GridGeometry target = grid(20, 18, 30, {1, 1, 1}, {-32, 10, 5}, obliqueDirection(0.3));
  const GridGeometry turned = grid(16, 14, 24, {1.2, 1.2, 1}, {-31, 11, 7}, obliqueDirection(0.33));
  Stack scan;
  scan.image = constantOn(turned, 1);
  ThreadPool pool(2);
  JoinedVolumes joined(target);
  joined.add(volumeInSpace(turned, ramp), scan, pool);
  const Volume result = joined.take();
  const Affine3 map = target.indexToWorld(), back = inverse(turned.indexToWorld());
  std::int64_t inner = 0, outside = 0, v = 0;
  for (int k = 0; k < 30; ++k)
    for (int j = 0; j < 18; ++j)
      for (int i = 0; i < 20; ++i, ++v) {
        const Vec3 x = map({double(i), double(j), double(k)});
        const double depth = depthInside(turned, back(x));
        if (depth < -1e-6) {
          ++outside;
          EXPECT_TRUE(std::isnan(result.voxels[v]));
        } else if (depth > 2) {
          ++inner;
          EXPECT_NEAR(result.voxels[v], ramp(x), 1e-2);
        }
      }
  EXPECT_GT(inner, 1000);
  EXPECT_GT(outside, 500);
}

TEST(JoinedVolumes, PassFromOneScanToTheOtherWithoutAStep) {
  const Volume whole = constantOn(kWhole, 0);
  Stack low = slab(whole, 0, 12), high = slab(whole, 8, 12);
  ThreadPool pool(2);
  JoinedVolumes joined(kWhole);
  joined.add(constantOn(low.image.geometry, 100), low, pool);
  joined.add(constantOn(high.image.geometry, 200), high, pool);
  const Volume result = joined.take();
  const std::int64_t centre = 8 + std::int64_t{16} * 7;
  float last = 100;
  for (int k = 0; k < 20; ++k) {
    const float value = result.voxels[centre + k * kPlane];
    EXPECT_GE(value, last);
    EXPECT_LE(value - last, 45) << "slice " << k;
    last = value;
  }
  EXPECT_EQ(last, 200);
  EXPECT_EQ(result.voxels[centre + 7 * kPlane], 100);
}

TEST(JoinedVolumes, LeaveTheUnobservedToTheOthers) {
  const Volume whole = constantOn(kWhole, 0);
  Stack both = slab(whole, 0, 20), part = both;
  part.observed.assign(part.image.voxels.size(), 1);
  std::fill_n(part.observed.begin(), 10 * kPlane, 0);
  ThreadPool pool(2);
  JoinedVolumes joined(kWhole);
  joined.add(constantOn(kWhole, 100), both, pool);
  joined.add(constantOn(kWhole, 200), part, pool);
  const Volume result = joined.take();
  const std::int64_t centre = 8 + std::int64_t{16} * 7;
  EXPECT_NEAR(result.voxels[centre + 5 * kPlane], 100, 0.1);
  EXPECT_NEAR(result.voxels[centre + 14 * kPlane], 150, 0.1);
}

} // namespace
} // namespace innergs::testing
