#include "Core/Motion/TimeSeries.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace innergs {

void checkTimeSeries(const TimeSeries& series) {
  const std::string what = series.name.empty() ? "The series" : series.name;
  checkGeometry(series.geometry, what);
  const auto fail = [&](ErrorCode code, const std::string& sentence) { throw Error(code, what + sentence); };
  if (series.size() < 2)
    fail(ErrorCode::InvalidArgument,
         " has a single frame; a dynamic scan needs at least two: for one volume use reconstruct.");
  if (series.times.size() != series.frames.size())
    fail(ErrorCode::InvalidArgument, " has " + std::to_string(series.times.size()) + " times for " +
                                         std::to_string(series.frames.size()) +
                                         " frames: give one per frame.");
  const auto voxels = static_cast<std::size_t>(series.geometry.voxelCount());
  for (const auto& frame : series.frames)
    if (frame.size() != voxels)
      fail(ErrorCode::Geometry, " has frames of different sizes: put them on one grid first.");
  for (std::size_t f = 0; f < series.times.size(); ++f) {
    if (!std::isfinite(series.times[f]))
      fail(ErrorCode::InvalidArgument, " has a time that is not finite: correct it.");
    if (f > 0 && !(series.times[f] > series.times[f - 1]))
      fail(ErrorCode::InvalidArgument, " has times that do not increase (" + numberText(series.times[f - 1]) +
                                           " s, then " + numberText(series.times[f]) +
                                           " s): order the frames by their times, each once.");
  }
  if (const SliceTiming& timing = series.sliceTiming; !timing.empty()) {
    if (timing.axis < 0 || timing.axis > 2 ||
        timing.times.size() != static_cast<std::size_t>(series.geometry.size[timing.axis]))
      fail(ErrorCode::InvalidArgument,
           " has " + std::to_string(timing.times.size()) +
               " slice times, which is not one per slice: correct or remove them.");
    for (const double time : timing.times)
      if (!(time >= 0 && time <= 1e6))
        fail(ErrorCode::InvalidArgument,
             " has a slice time that is below 0 s or not finite: correct or remove it.");
    double longest = 0;
    for (std::size_t f = 1; f < series.times.size(); ++f)
      longest = std::max(longest, series.times[f] - series.times[f - 1]);
    const double last = *std::max_element(timing.times.begin(), timing.times.end());
    if (last > 1.01 * longest)
      fail(ErrorCode::InvalidArgument,
           " has a slice acquired " + numberText(last) + " s after its frame began, and " +
               numberText(longest) +
               " s from one frame to the next: give both in seconds, or correct the slice times.");
  }
  const ValueRange range = rangeOf(series);
  bool equal = !(range.high > range.low);
  if (!equal) {
    equal = true;
    const auto same = [](float a, float b) { return a == b || (!std::isfinite(a) && !std::isfinite(b)); };
    for (std::size_t f = 1; f < series.frames.size() && equal; ++f)
      equal = std::equal(series.frames[0].begin(), series.frames[0].end(), series.frames[f].begin(), same);
  }
  if (equal)
    fail(ErrorCode::NoData, " has identical frames, so nothing changes: reconstruct one frame instead.");
}

double secondsOf(const std::string& unit) {
  static const std::map<std::string, double> known{
      {"s", 1},       {"sec", 1},      {"second", 1},       {"seconds", 1},        {"ms", 1e-3},
      {"msec", 1e-3}, {"us", 1e-6},    {"\xc2\xb5s", 1e-6}, {"millisecond", 1e-3}, {"milliseconds", 1e-3},
      {"min", 60},    {"minutes", 60}, {"h", 3600}};
  const auto found = known.find(unit);
  return found == known.end() ? 0 : found->second;
}

std::vector<double> checkedTimes(std::vector<double> times, const std::vector<double>& own) {
  const double first = own.front(), last = own.back(), slack = 1e-6 * std::max(1.0, last - first);
  for (std::size_t f = 0; f < times.size(); ++f) {
    if (!(times[f] >= first - slack && times[f] <= last + slack))
      throw Error(ErrorCode::InvalidArgument,
                  numberText(times[f]) + " s lies outside the time that the frames cover, " +
                      numberText(first) + " s to " + numberText(last) + " s: choose a time within it.");
    if (f > 0 && !(times[f] > times[f - 1]))
      throw Error(ErrorCode::InvalidArgument, "The times of the frames must increase, each time once.");
  }
  return times;
}

std::vector<double> timesAtRate(double rate, const std::vector<double>& own) {
  if (rate == 0) return own;
  constexpr double most = 100'000; // frames
  if (!(std::isfinite(rate) && rate > 0))
    throw Error(ErrorCode::InvalidArgument, "The rate must be above 0 frames per second.");
  const double first = own.front(), last = own.back();
  if ((last - first) * rate > most)
    throw Error(ErrorCode::InvalidArgument, "The rate gives far too many frames: choose a lower one.");
  const auto count = static_cast<std::int64_t>((last - first) * rate * (1 + 1e-9));
  std::vector<double> times;
  for (std::int64_t f = 0; f <= count; ++f)
    times.push_back(std::min(last, first + static_cast<double>(f) / rate));
  return times;
}

TimeSeries framesOf(const TimeSeries& series, const std::vector<std::int64_t>& frames) {
  TimeSeries chosen{series.geometry, {}, {}, series.name, series.sliceTiming};
  for (const std::int64_t f : frames) {
    chosen.frames.push_back(series.frames[f]);
    chosen.times.push_back(series.times[f]);
  }
  return chosen;
}

ValueRange rangeOf(const TimeSeries& series) {
  ValueRange range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
  for (const auto& frame : series.frames)
    for (const float v : frame)
      if (std::isfinite(v)) {
        range.low = std::min(range.low, v);
        range.high = std::max(range.high, v);
      }
  if (range.low > range.high)
    throw Error(ErrorCode::NoData,
                (series.name.empty() ? "The series" : series.name) + " has no finite voxel.");
  return range;
}

} // namespace innergs
