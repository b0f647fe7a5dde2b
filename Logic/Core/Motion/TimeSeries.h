#pragma once
#include "Core/Image/Volume.h"
#include "Core/Motion/SliceTiming.h"

#include <string>
#include <vector>

namespace innergs {

/// Volumes of one grid at increasing times: a dynamic scan. Times need not be evenly spaced; frames may be
/// missing.
struct TimeSeries {
  GridGeometry geometry;
  std::vector<std::vector<float>> frames; // voxels as in Volume, scanner units; not finite = not observed
  std::vector<double> times;              // of the frames, s, increasing
  std::string name;                       // for messages and reports (file name)
  SliceTiming sliceTiming;                // of all frames

  std::int64_t size() const { return static_cast<std::int64_t>(frames.size()); }
};

/// Throws Error(Geometry | InvalidArgument | NoData) for fewer than two frames, frames of another size than
/// the grid, times that do not increase, a slice timing that does not match the grid, and frames that
/// are all equal.
void checkTimeSeries(const TimeSeries& series);

/// Seconds in a unit of time as named in files and scenes ("s", "ms", "min" ...); 0: not a unit of time.
double secondsOf(const std::string& unit);

/// Checks the times (s) at which to make frames against those of a series (`own`), and returns them. Throws
/// Error(InvalidArgument) for times outside `own` and times that do not increase.
std::vector<double> checkedTimes(std::vector<double> times, const std::vector<double>& own);
/// Times at `rate` frames per second over all of `own`; 0: `own` itself. Throws Error(InvalidArgument).
std::vector<double> timesAtRate(double rate, const std::vector<double>& own);

/// A series of these frames only, in that order.
TimeSeries framesOf(const TimeSeries& series, const std::vector<std::int64_t>& frames);

/// Smallest and largest finite value of all frames. Throws Error(NoData) where there is none.
ValueRange rangeOf(const TimeSeries& series);

} // namespace innergs
