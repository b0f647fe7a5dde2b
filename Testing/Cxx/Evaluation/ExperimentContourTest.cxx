#include "Evaluation/ExperimentContour.h"
#include "Core/Base/Error.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace innergs;

TEST(ExperimentContour, SplatIsTheSlicedGaussian) {
  ContourCheck check;
  check.gaussians = 100;
  const ContourResult result = checkContours(check);
  EXPECT_EQ(result.points, 100 * check.slices * check.grid * check.grid);
  EXPECT_GT(result.contourPoints, 100 * check.slices * check.directions);
  EXPECT_LT(result.maximumError, 1e-12);
  EXPECT_LT(result.maximumDistance, 1e-6);
  EXPECT_GT(result.maximumError, 0); // two separate computations
}

TEST(ExperimentContour, ExampleHoldsBothContours) {
  ContourCheck check;
  check.gaussians = 1;
  const ContourResult result = checkContours(check);
  ASSERT_EQ(result.example.size(), 5u);
  for (const ContourSlice& slice : result.example) {
    EXPECT_EQ(slice.sliced.size(), std::size_t(slice.size) * slice.size);
    ASSERT_EQ(slice.contours.size(), 3u);
    const double peak = std::exp(-0.5 * slice.t * slice.t);
    for (const auto& contour : slice.contours) {
      EXPECT_EQ(contour.splat.empty(), peak < contour.level) << slice.t << " " << contour.level;
      ASSERT_EQ(contour.sliced.size(), contour.splat.size());
      for (std::size_t n = 0; n < contour.splat.size(); ++n) {
        EXPECT_NEAR(contour.splat[n][0], contour.sliced[n][0], 1e-6);
        EXPECT_NEAR(contour.splat[n][1], contour.sliced[n][1], 1e-6);
        EXPECT_LT(std::abs(contour.splat[n][0]), slice.extent);
        EXPECT_LT(std::abs(contour.splat[n][1]), slice.extent);
      }
    }
  }
}

TEST(ExperimentContour, TableSaysThatNothingIsHeldOut) {
  ContourCheck check;
  check.gaussians = 2;
  const ExperimentTable table = contourTable(check, checkContours(check));
  EXPECT_EQ(csvOf(table).substr(0, 42), "measure,value,paper,compared,measured_on\nl");
  EXPECT_NE(textOf(table).find("Nothing is held out"), std::string::npos);
}

TEST(ExperimentContour, RefusesNothingAndStops) {
  ContourCheck check;
  check.gaussians = 0;
  EXPECT_THROW(checkContours(check), Error);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_THROW(checkContours({}, stop.get_token()), Error);
}
