#include "Core/Image/CubicConvolution.h"

#include "Core/Base/InstructionSets.h"
#include "Core/Base/Random.h"
#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// Of each instruction set but the reference.
class CubicConvolutionOf : public ::testing::TestWithParam<std::string> {
protected:
  /// Both add to what a row holds. Returns the number of its points inside the grid.
  int compareRow(const Volume& volume, const Vec3& start, const Vec3& step, int begin, int end) {
    std::vector<float> expected(static_cast<std::size_t>(end) + 3, 0.25F), got = expected;
    kernelsOf(cubicConvolutions(), "scalar").add(volume, start, step, -0.75F, begin, end, expected.data());
    kernelsOf(cubicConvolutions(), GetParam()).add(volume, start, step, -0.75F, begin, end, got.data());
    int inside = 0;
    for (std::size_t i = 0; i < got.size(); ++i) {
      EXPECT_NEAR(got[i], expected[i], 5e-6) << "point " << i;
      inside += expected[i] != 0.25F;
    }
    return inside;
  }
};

std::vector<std::string> fastSets() {
  std::vector<std::string> names;
  for (const CubicConvolution& set : cubicConvolutions())
    if (set.name != "scalar") names.push_back(set.name);
  return names;
}

} // namespace

TEST(CubicConvolutions, ScalarIsTheLastOfSeveralSets) {
  ASSERT_GE(cubicConvolutions().size(), 2u);
  EXPECT_EQ(cubicConvolutions().back().name, "scalar");
}

TEST_P(CubicConvolutionOf, RowsInAnyDirectionAreThoseOfTheReference) {
  const Volume volume = randomVolume(grid(23, 17, 11), -1, 1, 3);
  Random random(5);
  int inside = 0, points = 0;
  for (int trial = 0; trial < 200; ++trial) {
    Vec3 start, step;
    for (int a = 0; a < 3; ++a) {
      start[a] = random.uniform() * (volume.geometry.size[a] + 6.0) - 3;
      step[a] = (random.uniform() - 0.5) * (trial % 4 == 0 && a > 0 ? 0 : 1.5);
    }
    const int begin = trial % 5, end = begin + trial; // of every number of lanes and of points at a time
    inside += compareRow(volume, start, step, begin, end);
    points += end - begin;
  }
  EXPECT_GT(inside, 1000);
  EXPECT_LT(inside, points);
}

TEST_P(CubicConvolutionOf, OnVoxelsAndBetweenEdgeVoxels) {
  const Volume volume = randomVolume(grid(9, 8, 7), -1, 1, 4);
  EXPECT_EQ(compareRow(volume, {0, 3, 3}, {1, 0, 0}, 0, 9), 9);
  EXPECT_EQ(compareRow(volume, {8 + 1e-9, 7 - 1e-9, 6}, {-1, -1, -1}, 0, 12), 7);
  EXPECT_EQ(compareRow(volume, {-0.4, -0.4, -0.4}, {0.1, 0.1, 0.1}, 0, 60), 60);
  EXPECT_EQ(compareRow(volume, {8.4, 7.4, 6.4}, {-0.1, -0.1, -0.1}, 0, 60), 60);
}

TEST_P(CubicConvolutionOf, GridsOfAFewVoxels) {
  for (const int nx : {1, 2, 3, 4, 5})
    for (const int nz : {1, 2, 5}) {
      const Volume volume = randomVolume(grid(nx, 2, nz), -1, 1, 6);
      EXPECT_GT(compareRow(volume, {-0.8, 0.3, 0.1}, {0.13, 0.01, 0.02}, 0, 70), 0);
    }
}

TEST_P(CubicConvolutionOf, PointsThatAreNowhere) {
  const Volume volume = randomVolume(grid(6, 6, 6), -1, 1, 7);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(compareRow(volume, {nan, 2, 2}, {1, 0, 0}, 0, 20), 0);
  EXPECT_EQ(compareRow(volume, {1e300, -1e300, 2}, {1e300, 0, 0}, 0, 20), 0);
  EXPECT_EQ(compareRow(volume, {2, 2, 2}, {1, 0, 0}, 5, 5), 0);
}

INSTANTIATE_TEST_SUITE_P(InstructionSets, CubicConvolutionOf, ::testing::ValuesIn(fastSets()),
                         [](const auto& set) { return set.param; });

TEST(CubicConvolutions, KeysOptimumIsExactOnParabolas) {
  const auto parabola = [](double i, double j, double k) {
    return 3 + 0.5 * i * i - 0.3 * i * j + 0.2 * k * k;
  };
  const Volume volume = volumeOf(
      grid(9, 8, 7), [&](auto i, auto j, auto k) { return parabola(double(i), double(j), double(k)); });
  for (const Vec3& x : {Vec3{2.3, 3.8, 2.5}, Vec3{5.9, 1.1, 3.2}}) {
    EXPECT_NEAR(cubicAt(volume, x), parabola(x[0], x[1], x[2]), 1e-4);
    EXPECT_GT(std::abs(cubicAt(volume, x, -0.75F) - parabola(x[0], x[1], x[2])), 0.01);
  }
}
