#include "MovingPhantom.h"

#include "Core/Base/Error.h"

#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

Error errorOf(const TimeSeries& series) {
  try {
    checkTimeSeries(series);
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "nothing was refused";
  return {ErrorCode::Internal, ""};
}

} // namespace

TEST(TimeSeries, UnevenTimesAndBrokenVoxelsAreFine) {
  TimeSeries series = movingPhantom({0, 0.4, 1.9});
  series.frames[1][5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NO_THROW(checkTimeSeries(series));
}

TEST(TimeSeries, RefusesWhatIsNoMovingScan) {
  EXPECT_EQ(errorOf(movingPhantom({0})).code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOf(movingPhantom({0, 1, 1})).code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOf(movingPhantom({0, 2, 1})).code(), ErrorCode::InvalidArgument);
  EXPECT_EQ(errorOf(movingPhantom({0, std::numeric_limits<double>::quiet_NaN()})).code(),
            ErrorCode::InvalidArgument);
  TimeSeries series = movingPhantom({0, 1, 2});
  series.times.pop_back();
  EXPECT_EQ(errorOf(series).code(), ErrorCode::InvalidArgument);
  series = movingPhantom({0, 1, 2});
  series.frames[1].pop_back();
  EXPECT_EQ(errorOf(series).code(), ErrorCode::Geometry);
  series = movingPhantom({0, 1, 2});
  series.frames[1] = series.frames[2] = series.frames[0];
  EXPECT_EQ(errorOf(series).code(), ErrorCode::NoData);
  for (auto& frame : series.frames)
    frame.assign(frame.size(), std::numeric_limits<float>::infinity());
  EXPECT_EQ(errorOf(series).code(), ErrorCode::NoData);
}
