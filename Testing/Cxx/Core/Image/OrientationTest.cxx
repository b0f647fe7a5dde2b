#include "Core/Image/Orientation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

using namespace innergs;

namespace {

Mat3 rotation(int axis, double angle) {
  Mat3 r{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  r[a][a] = r[b][b] = std::cos(angle);
  r[a][b] = -std::sin(angle);
  r[b][a] = std::sin(angle);
  return r;
}

} // namespace

TEST(Orientation, OfGridsAlongThePatientsAxes) {
  EXPECT_EQ(orientationCode({{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}}), "LPS");
  EXPECT_EQ(orientationCode({{{{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}}}), "RAS");
  EXPECT_EQ(orientationCode({{{{0, 0, -1}, {1, 0, 0}, {0, -1, 0}}}}), "PIR"); // sagittal slices
}

// ITK and nibabel also say LPS; two of its columns point mostly to the head.
TEST(Orientation, OfADoubleObliqueStackNamesEachAxisOnce) {
  const Mat3 direction = rotation(0, 0.7) * rotation(1, -0.7);
  const auto main = [&](int a) {
    const Vec3 v = column(direction, a);
    return std::max_element(v.begin(), v.end(),
                            [](double x, double y) { return std::abs(x) < std::abs(y); }) -
           v.begin();
  };
  ASSERT_TRUE(main(1) == main(2) || main(0) == main(2) || main(0) == main(1)) << "no hard case";
  EXPECT_EQ(orientationCode(direction), "LPS");
}

TEST(Orientation, IsAPermutationForEveryRotation) {
  for (int n = 0; n < 2000; ++n) {
    const Mat3 direction = rotation(2, 0.37 * n) * rotation(0, 0.73 * n) * rotation(1, 0.11 * n);
    const std::array<int, 3> axes = nearestAxes(direction);
    ASSERT_EQ((std::set<int>{axes[0], axes[1], axes[2]}.size()), 3u) << n;
    // No swap of two axes is nearer.
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3;
      ASSERT_GE(std::abs(direction[axes[a]][a]) + std::abs(direction[axes[b]][b]) + 1e-6,
                std::abs(direction[axes[b]][a]) + std::abs(direction[axes[a]][b]))
          << n;
    }
  }
}
