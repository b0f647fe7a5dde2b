#include "Core/Acquisition/Observation.h"
#include "TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>

using namespace innergs;
using namespace innergs::testing;

namespace {

double secondMoment(const ProfileQuadrature& q) {
  double sum = 0;
  for (std::size_t i = 0; i < q.offset.size(); ++i)
    sum += q.weight[i] * q.offset[i] * q.offset[i];
  return sum;
}

Stack stackOf(const GridGeometry& geometry, SliceProfile profile = SliceProfile::Point) {
  Stack stack;
  stack.image = volumeOf(geometry, [](auto i, auto j, auto k) { return 100 + i + 20 * j + 400 * k; });
  stack.profile = profile;
  return stack;
}

} // namespace

TEST(ProfileQuadrature, SumsToOneAndIsSymmetric) {
  for (const SliceProfile profile : {SliceProfile::Point, SliceProfile::Box, SliceProfile::Gaussian})
    for (const double thickness : {0.4, 1.0, 2.0, 5.0, 12.0, 40.0})
      for (const double resolution : {0.3, 1.0, 2.5}) {
        const auto q = profileQuadrature(profile, thickness, resolution);
        SCOPED_TRACE(::testing::Message()
                     << static_cast<int>(profile) << " " << thickness << " " << resolution);
        ASSERT_FALSE(q.offset.empty());
        ASSERT_EQ(q.offset.size(), q.weight.size());
        EXPECT_NEAR(std::accumulate(q.weight.begin(), q.weight.end(), 0.0), 1, 1e-12);
        for (std::size_t i = 0; i < q.offset.size(); ++i) {
          EXPECT_NEAR(q.offset[i], -q.offset[q.offset.size() - 1 - i], 1e-12);
          EXPECT_NEAR(q.weight[i], q.weight[q.offset.size() - 1 - i], 1e-12);
          EXPECT_GT(q.weight[i], 0);
        }
        EXPECT_TRUE(std::is_sorted(q.offset.begin(), q.offset.end()));
        EXPECT_LE(q.offset.size(), 512u); // bounded for any thickness
      }
}

TEST(ProfileQuadrature, HasTheProfilesWidth) {
  // Variance: T²/12 for a box, (T/2.3548)² for a Gaussian.
  EXPECT_NEAR(secondMoment(profileQuadrature(SliceProfile::Box, 6, 1)), 3.0, 0.1);
  EXPECT_NEAR(secondMoment(profileQuadrature(SliceProfile::Gaussian, 6, 1)), 36 / 5.545, 0.1 * 36 / 5.545);
  EXPECT_EQ(profileQuadrature(SliceProfile::Point, 6, 1).offset, std::vector<double>{0.0});
  EXPECT_EQ(profileQuadrature(SliceProfile::Box, 0.5, 1).offset,
            std::vector<double>{0.0}); // thinner than a voxel
}

TEST(ProfileQuadrature, OfTwoPointsIsExactForCubics) {
  for (const SliceProfile profile : {SliceProfile::Box, SliceProfile::Gaussian}) {
    const auto q = twoPointQuadrature(profile, 6);
    ASSERT_EQ(q.offset.size(), 2u);
    EXPECT_NEAR(q.weight[0] + q.weight[1], 1, 1e-12);
    EXPECT_NEAR(q.offset[0], -q.offset[1], 1e-12);
    EXPECT_NEAR(secondMoment(q), profile == SliceProfile::Box ? 3.0 : 36 / 5.545177444, 1e-6);
  }
}

TEST(Observation, HoldsTheStacksSamplesAtTheirPlaces) {
  Stack stack = stackOf(grid(5, 4, 3, {1, 2, 3}, {7, -8, 9}, obliqueDirection(0.6)));
  stack.image.voxels[1] = std::numeric_limits<float>::quiet_NaN();
  stack.image.voxels[2] = -std::numeric_limits<float>::infinity();
  stack.observed.assign(60, 1);
  stack.observed[3] = 0;
  const Affine3 frame{obliqueDirection(-0.2), {1, 2, 3}};
  const auto all = observe(stack, frame, {50, 100}, false);
  ASSERT_EQ(all.size(), 1u);
  const Observation& o = all[0];
  EXPECT_EQ(o.slices, 3);
  EXPECT_EQ(o.samples, 57);
  EXPECT_EQ(o.target.size(), 3 * o.sliceSize());
  const int stride = o.grid.stride();
  EXPECT_EQ(o.weight[0], 1);
  for (int x : {1, 2, 3})
    EXPECT_EQ(o.weight[x], 0);
  for (int k = 0; k < 3; ++k)
    for (int y = 0; y < 4; ++y) {
      for (int x = 0; x < stride; ++x) {
        const std::size_t v = k * o.sliceSize() + y * stride + x;
        ASSERT_TRUE(std::isfinite(o.target[v]));
        if (x >= 5) {
          EXPECT_EQ(o.weight[v], 0) << "padding";
        } else if (o.weight[v]) {
          EXPECT_NEAR(o.target[v], (x + 20 * y + 400 * k) / 50.0, 1e-5);
        }
      }
      const Vec3 world = stack.image.geometry.indexToWorld()({1, double(y), double(k)});
      EXPECT_LT(norm(frame(o.grid.indexToModel({1, double(y), o.grid.z[k]})) - world), 1e-9);
    }
}

TEST(Observation, LeavesOutSlicesWithoutSamples) {
  Stack stack = stackOf(grid(5, 4, 4), SliceProfile::Box);
  stack.thickness = 4;
  stack.observed.assign(80, 1);
  std::fill_n(stack.observed.begin() + 20, 20, std::uint8_t{0});
  const auto all = observe(stack, {}, {}, false);
  ASSERT_EQ(all.size(), 1u);
  const Observation& o = all[0];
  EXPECT_EQ(o.sourceSlice, (std::vector<int>{0, 2, 3}));
  EXPECT_EQ(o.perSlice, 4);
  EXPECT_TRUE(std::is_sorted(o.grid.z.begin(), o.grid.z.end()));
  for (int s = 0; s < 3; ++s) {
    double centre = 0, weight = 0;
    for (int q = 0; q < 4; ++q) {
      const auto sub = o.subPlanes[4 * s + q];
      centre += sub.weight * o.grid.z[sub.plane];
      weight += sub.weight;
    }
    EXPECT_NEAR(weight, 1, 1e-6);
    EXPECT_NEAR(centre, o.sourceSlice[s], 1e-6);
  }
}

TEST(Observation, OfPosedSlicesIsOnePerSlice) {
  Stack stack = stackOf(grid(5, 4, 3));
  for (int k = 0; k < 3; ++k)
    stack.poses.push_back({obliqueDirection(0.1 * k), {0, 10.0 * k, 0}});
  const auto all = observe(stack, {}, {}, false);
  ASSERT_EQ(all.size(), 3u);
  for (int k = 0; k < 3; ++k) {
    EXPECT_EQ(all[k].slices, 1);
    EXPECT_EQ(all[k].sourceSlice, std::vector<int>{k});
    const Vec3 at = all[k].grid.indexToModel({2, 1, all[k].grid.z.at(0)});
    EXPECT_LT(norm(at - stack.poses[k]({2, 1, double(k)})), 1e-9);
  }
}

TEST(Observation, CoarsenedKeepsMeansAndPlaces) {
  struct Case {
    double thickness;     // mm; slices lie 1 mm apart
    int slices, perSlice; // of the coarse observation
    bool posed = false;
  };
  for (const Case& c : {Case{1, 3, 1}, Case{3, 6, 3}, Case{3, 1, 2, true}, Case{4, 1, 2, true}}) {
    SCOPED_TRACE(::testing::Message() << c.thickness << " mm" << (c.posed ? ", posed" : ""));
    Stack stack = stackOf(grid(7, 6, 6), c.thickness > 1 ? SliceProfile::Box : SliceProfile::Point);
    stack.thickness = c.thickness;
    if (c.posed) stack.poses.resize(6);
    stack.observed.assign(stack.image.voxels.size(), 1);
    stack.observed[0] = 0;
    const Observation fine = observe(stack, {}, {}, false).at(0), coarse = coarsened(fine);
    EXPECT_EQ(coarse.grid.nx, 4);
    EXPECT_EQ(coarse.grid.ny, 3);
    EXPECT_EQ(coarse.slices, c.slices);
    EXPECT_EQ(coarse.perSlice, c.perSlice);
    EXPECT_EQ(coarse.subPlanes.size(), static_cast<std::size_t>(coarse.slices * coarse.perSlice));
    EXPECT_EQ(coarse.samples, 4 * 3 * coarse.slices);
    // The image is linear in position, so a block's mean is the value at its centre.
    const auto linear = [](const Vec3& x) { return 100 + x[0] + 20 * x[1] + 400 * x[2]; };
    for (int s = 0; s < coarse.slices; ++s)
      for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 3; ++x) { // the last column is half a block
          if (s == 0 && y == 0 && x == 0) continue;
          Vec3 at{0, 0, 0};
          for (int q = 0; q < coarse.perSlice; ++q) {
            const auto sub = coarse.subPlanes[s * coarse.perSlice + q];
            at = at + static_cast<double>(sub.weight) *
                          coarse.grid.indexToModel({double(x), double(y), coarse.grid.z[sub.plane]});
          }
          const std::size_t v = s * coarse.sliceSize() + y * coarse.grid.stride() + x;
          EXPECT_EQ(coarse.weight[v], 1);
          EXPECT_NEAR(coarse.target[v], linear(at), 2e-3);
        }
  }
}
