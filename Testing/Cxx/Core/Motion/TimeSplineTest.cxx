#include "Core/Motion/TimeSpline.h"

#include <gtest/gtest.h>

using namespace innergs;

TEST(TimeSpline, WeightsSumToOneAndHoldBeyondTheEnds) {
  const TimeSpline spline{2, 5, 9};
  for (const double t : {-1.0, 2.0, 2.7, 4.99, 5.0, 8.0}) {
    const auto w = spline.at(t);
    float sum = 0;
    for (int a = 0; a < w.count; ++a)
      sum += w.weight[a];
    EXPECT_NEAR(sum, 1, 1e-6) << t;
    EXPECT_GE(w.first, 0);
    EXPECT_LE(w.first + w.count, spline.coefficients);
  }
  EXPECT_EQ(spline.at(8).weight, spline.at(5).weight);
  EXPECT_EQ((TimeSpline{0, 1, 1}).at(0.3).count, 1);
}

TEST(TimeSpline, FitReproducesCubicsAtUnevenTimes) {
  const TimeSpline spline{0, 6, 7};
  const std::vector<double> times{0, 0.2, 1.1, 1.5, 2.9, 3.3, 4.0, 5.4, 6}, where{0.7, 2.2, 4.7};
  const auto cubic = [](double t) { return 1 - 2 * t + 0.3 * t * t - 0.05 * t * t * t; };
  const auto rows = splinePrediction(spline, times, where, 0);
  for (std::size_t i = 0; i < where.size(); ++i) {
    double value = 0;
    for (std::size_t t = 0; t < times.size(); ++t)
      value += rows[i * times.size() + t] * cubic(times[t]);
    EXPECT_NEAR(value, cubic(where[i]), 2e-4) << where[i];
  }
}

TEST(TimeSpline, MuchSmoothingLeavesAStraightLine) {
  const TimeSpline spline{0, 4, 8};
  const std::vector<double> times{0, 1, 2, 3, 4}, values{0, 3, 1, 5, 6}, where{0.5, 3.5};
  const auto rows = splinePrediction(spline, times, where, 1e7);
  const auto line = [](double t) { return 3 + 1.4 * (t - 2); }; // least squares
  for (std::size_t i = 0; i < where.size(); ++i) {
    double value = 0;
    for (std::size_t t = 0; t < times.size(); ++t)
      value += rows[i * times.size() + t] * values[t];
    EXPECT_NEAR(value, line(where[i]), 0.01);
  }
}

TEST(TimeSpline, IsDefinedWithFewerFramesThanCoefficients) {
  const TimeSpline spline{0, 10, 6};
  const std::vector<double> times{0, 10}, where{5};
  const auto rows = splinePrediction(spline, times, where, 0);
  EXPECT_NEAR(rows[0], 0.5, 1e-3);
  EXPECT_NEAR(rows[1], 0.5, 1e-3);
}
