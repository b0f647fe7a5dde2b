#include "Core/Prediction/ConvexShares.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

TEST(ConvexShares, ShareWhatErrsDifferently) {
  Covariance<3> apart{};
  apart[0][0] = apart[1][1] = 1;
  apart[2][2] = 9;
  const std::array<double, 3> share = convexShares<3>(apart);
  EXPECT_NEAR(share[0], 0.5, 0.06);
  EXPECT_NEAR(share[1], 0.45, 0.06);
  EXPECT_LT(share[2], 0.11);
}

TEST(ConvexShares, TakeTheBestAloneWhereTheOthersErrLikeIt) {
  Covariance<4> alike{};
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b)
      alike[a][b] = (a + 1.0) * (b + 1.0);
  EXPECT_EQ(convexShares<4>(alike), (std::array<double, 4>{1, 0, 0, 0}));
}

TEST(ConvexShares, HaveTheLeastCost) {
  const std::array<double, 4> wanted{0.1, 0.35, 0, 0.55};
  const auto share = convexShares<4>([&](const std::array<double, 4>& s) {
    double distance = 0;
    for (int n = 0; n < 4; ++n)
      distance += std::abs(s[n] - wanted[n]);
    return distance;
  });
  double sum = 0;
  for (int n = 0; n < 4; ++n) {
    EXPECT_NEAR(share[n], wanted[n], 1e-12);
    sum += share[n];
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(ConvexShares, AreOfTheFirstAloneWhereNoCostIsKnown) {
  const auto share = convexShares<3>([](const std::array<double, 3>&) { return std::nan(""); });
  EXPECT_EQ(share, (std::array<double, 3>{1, 0, 0}));
}

} // namespace
} // namespace innergs::testing
