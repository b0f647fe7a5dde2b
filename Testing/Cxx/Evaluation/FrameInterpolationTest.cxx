#include "Evaluation/FrameInterpolation.h"

#include "Core/Image/Metrics.h"
#include "Evaluation/JitteredPhantom.h"

#include <cmath>
#include <gtest/gtest.h>

using namespace innergs;

namespace {

/// value(time) in every voxel of a small grid.
template <class Value>
TimeSeries uniform(const std::vector<double>& times, const Value& value) {
  TimeSeries series;
  series.geometry.size = {3, 2, 2};
  for (const double time : times)
    series.frames.emplace_back(12, static_cast<float>(value(time)));
  series.times = times;
  return series;
}

float at(const TimeSeries& series, double time, FrameMethod method) {
  const std::vector<double> times{time};
  return interpolateFrames(series, times, method).front().front();
}

} // namespace

TEST(FrameInterpolation, EveryMethodDoesWhatItsNameSays) {
  const auto square = [](double t) { return t * t; };
  const TimeSeries series = uniform({0, 1, 3, 4}, square);
  EXPECT_EQ(at(series, 1.5, FrameMethod::Previous), 1);
  EXPECT_EQ(at(series, 2.5, FrameMethod::Nearest), 9);
  EXPECT_EQ(at(series, 1.5, FrameMethod::Linear), 3);
  EXPECT_EQ(at(series, 1.5, FrameMethod::Mean), 6.5);
  for (const FrameMethod method :
       {FrameMethod::Previous, FrameMethod::Nearest, FrameMethod::Linear, FrameMethod::Cubic})
    for (std::size_t f = 0; f < series.times.size(); ++f)
      EXPECT_NEAR(at(series, series.times[f], method), series.frames[f][0], 1e-5) << frameMethodName(method);
}

TEST(FrameInterpolation, SplinesFollowSmoothCourses) {
  std::vector<double> times;
  for (int f = 0; f < 20; ++f)
    times.push_back(0.4 * f);
  const auto wave = [](double t) { return std::sin(0.8 * t); };
  const TimeSeries series = uniform(times, wave);
  EXPECT_NEAR(at(series, 3.8, FrameMethod::Cubic), wave(3.8), 1e-3);
  EXPECT_NEAR(at(series, 3.8, FrameMethod::Spline), wave(3.8), 1e-2);
}

TEST(FrameInterpolation, DemonsCarriesTissueHalfTheWay) {
  JitteredPhantom phantom;
  phantom.geometry.size = {40, 40, 6};
  phantom.angleJitter = phantom.shiftJitter = phantom.noise = 0;
  phantom.frames = 5;
  phantom.swing = 20;
  phantom.period = 10;
  const TimeSeries all = makeJitteredPhantom(phantom);
  const TimeSeries kept = framesOf(all, {0, 1, 3, 4});
  const auto linear = interpolateFrames(kept, std::vector<double>{all.times[2]}, FrameMethod::Linear).front();
  const auto moved = demonsFrame(kept, all.times[2]);
  EXPECT_GT(pooledPsnr(moved, all.frames[2], {}, 4000), pooledPsnr(linear, all.frames[2], {}, 4000) + 2);
}
