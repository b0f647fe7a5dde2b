#include "Core/Prediction/PredictionShares.h"

#include <gtest/gtest.h>
#include <numeric>

namespace innergs::testing {
namespace {

/// Independent errors of interpolation, field and what was learned.
Covariance<3> independent(double interpolation, double field, double learned) {
  Covariance<3> errors{};
  errors[0][0] = interpolation;
  errors[1][1] = field;
  errors[2][2] = learned;
  return errors;
}

TEST(PredictionShares, AreConvexAndOnlyOfWhatThereIs) {
  for (const bool field : {false, true})
    for (const bool learned : {false, true}) {
      const auto share = predictionShares(independent(2, 1.5, 1), {true, field, learned}, {1, 1, 1});
      EXPECT_NEAR(std::accumulate(share.begin(), share.end(), 0.0), 1, 1e-12);
      EXPECT_EQ(share[1] > 0, field);
      EXPECT_EQ(share[2] > 0, learned);
    }
}

TEST(PredictionShares, FollowTheErrorsExpectedAtTheDistanceItself) {
  Covariance<3> alike{}; // errors that are correlated, learning's smaller by a tenth
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      alike[a][b] = (a == 2 ? 0.9 : 1) * (b == 2 ? 0.9 : 1) * (a == b ? 1 : 0.98);
  const std::array<bool, 3> exists{true, false, true};
  EXPECT_EQ(predictionShares(alike, exists, {1, 1, 1})[2], 1);
  EXPECT_LT(predictionShares(alike, exists, {1, 1, 1.25})[2], 0.2);
}

TEST(PredictionShares, LearningIsDoubtedWhereItsGainShrinksWithTheDistance) {
  PairErrors twice, once;
  twice.linear = 170;
  twice.network = 110;
  once.linear = 100;
  once.network = 62;
  EXPECT_EQ(learnedRise(twice, once), 1);
  once.network = 76;
  EXPECT_NEAR(learnedRise(twice, once), 76. / 100 * 170 / 110 / 1.08, 1e-12);
  EXPECT_EQ(learnedRise({}, {}), 1);
}

} // namespace
} // namespace innergs::testing
