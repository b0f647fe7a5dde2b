#include "MovingPhantom.h"
#include "ThrownError.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

ErrorCode refusal(const TimeSeries& series) {
  return test::codeOf([&] { checkTimeSeries(series); });
}

} // namespace

TEST(TimeSeries, UnevenTimesAndBrokenVoxelsAreFine) {
  TimeSeries series = movingPhantom({0, 0.4, 1.9});
  series.frames[1][5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NO_THROW(checkTimeSeries(series));
}

TEST(TimeSeries, RefusesWhatIsNoMovingScan) {
  EXPECT_EQ(refusal(movingPhantom({0})), ErrorCode::InvalidArgument);
  EXPECT_EQ(refusal(movingPhantom({0, 1, 1})), ErrorCode::InvalidArgument);
  EXPECT_EQ(refusal(movingPhantom({0, 2, 1})), ErrorCode::InvalidArgument);
  EXPECT_EQ(refusal(movingPhantom({0, std::numeric_limits<double>::quiet_NaN()})),
            ErrorCode::InvalidArgument);
  TimeSeries series = movingPhantom({0, 1, 2});
  series.times.pop_back();
  EXPECT_EQ(refusal(series), ErrorCode::InvalidArgument);
  series = movingPhantom({0, 1, 2});
  series.frames[1].pop_back();
  EXPECT_EQ(refusal(series), ErrorCode::Geometry);
  series = movingPhantom({0, 1, 2});
  series.frames[1] = series.frames[2] = series.frames[0];
  EXPECT_EQ(refusal(series), ErrorCode::NoData);
  for (auto& frame : series.frames)
    frame.assign(frame.size(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(refusal(series), ErrorCode::NoData);
}
