#include "Core/Uncertainty/ErrorCurve.h"

#include "Core/Image/Simulate.h"
#include "Core/Uncertainty/LocalDetail.h"
#include "Core/Uncertainty/SliceDistance.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

namespace innergs {
namespace {

/// Errors whose deviation is 1 + detail.
std::vector<HeldOutError> growingErrors(std::size_t count, std::uint64_t seed, bool heavyTails) {
  std::vector<float> noise(count, 0.f);
  addNoise(noise, 1, seed);
  std::vector<HeldOutError> seen;
  for (std::size_t n = 0; n < count; ++n) {
    const auto detail = static_cast<float>(n % 100) / 10;
    const float r = heavyTails ? noise[n] * std::abs(noise[(n + 7) % count]) : noise[n];
    seen.push_back({detail, (1 + detail) * r});
  }
  return seen;
}

TEST(ErrorCurve, HoldsNinetyPercentOfFreshErrors) {
  for (const bool heavyTails : {false, true}) {
    const ErrorCurve curve(growingErrors(20000, 1, heavyTails));
    for (const float detail : {1.f, 5.f, 9.f}) { // at each detail, not only on the whole
      int held = 0, count = 0;
      for (const HeldOutError& e : growingErrors(60000, 2, heavyTails)) {
        if (std::abs(e.detail - detail) > 0.5f) continue;
        held += std::abs(e.error) <= kNinety * curve.at(e.detail);
        ++count;
      }
      EXPECT_NEAR(static_cast<double>(held) / count, 0.9, 0.02) << detail << heavyTails;
    }
    if (!heavyTails) {
      EXPECT_NEAR(curve.at(5), 6, 0.3);
    }
  }
}

TEST(ErrorCurve, GrowsWithTheDetail) {
  std::vector<HeldOutError> falling;
  for (int n = 0; n < 4000; ++n)
    falling.push_back({static_cast<float>(n), static_cast<float>(4000 - n)});
  const ErrorCurve curve(falling);
  for (int n = 0; n < 4000; n += 100)
    EXPECT_LE(curve.at(n), curve.at(n + 100));
  EXPECT_TRUE(ErrorCurve().empty());
  EXPECT_TRUE(std::isnan(ErrorCurve().at(1)));
  const ErrorCurve flat(std::vector<HeldOutError>(500, {2, -3}));
  EXPECT_NEAR(flat.at(0), 3 / kNinety, 1e-6);
  EXPECT_NEAR(flat.at(10), 3 / kNinety, 1e-6);
}

TEST(LocalDetail, IsTheSlopeOfARamp) {
  ThreadPool pool(2);
  Volume ramp;
  ramp.geometry.size = {12, 9, 1};
  ramp.geometry.spacing = {0.5, 2, 3};
  for (std::int64_t v = 0; v < ramp.geometry.voxelCount(); ++v)
    ramp.voxels.push_back(static_cast<float>(3 * (v % 12) * 0.5 + 4 * static_cast<double>(v / 12) * 2));
  for (const float slope : localDetail(ramp, 2, pool).voxels)
    EXPECT_NEAR(slope, 5, 1e-4);
}

TEST(SliceDistance, KnowsWhereNothingWasMeasured) {
  ThreadPool pool(2);
  Stack stack;
  GridGeometry& g = stack.image.geometry;
  g.size = {4, 4, 3};
  g.spacing = {1, 1, 6};
  stack.thickness = 2;
  stack.image.voxels.assign(48, 1.f);
  stack.image.voxels[16] = std::numeric_limits<float>::quiet_NaN(); // a hole in the middle slice
  stack.observed.assign(48, 1);
  std::fill(stack.observed.begin() + 32, stack.observed.end(), std::uint8_t{0}); // the last one is held out
  GridGeometry fine = g;
  fine.size = {4, 4, 19};
  fine.spacing = {1, 1, 1};
  const std::vector<std::uint8_t> measured = measuredVoxels(fine, std::span(&stack, 1), pool);
  const std::vector<float> near = sliceDistances(fine, std::span(&stack, 1), pool);
  for (std::int64_t k = 0; k < 19; ++k) {
    EXPECT_EQ(measured[k * 16 + 5], k <= 1 || (k >= 5 && k <= 7)) << k;
    EXPECT_EQ(measured[k * 16], k <= 1) << k;
    if (k <= 3) {
      EXPECT_FLOAT_EQ(near[k * 16 + 5], static_cast<float>(k) / 3);
    }
  }
  EXPECT_TRUE(std::isinf(near[18 * 16 + 5]));
  // The same slices, moved by 2 mm.
  stack.poses.assign(3, {Mat3{}, {0, 0, 2}});
  EXPECT_EQ(measuredVoxels(fine, std::span(&stack, 1), pool)[8 * 16 + 5], 1);
  EXPECT_EQ(measuredVoxels(fine, std::span(&stack, 1), pool)[5], 0);
}

} // namespace
} // namespace innergs
