#pragma once
#include "Core/Motion/TimeSeries.h"

#include <span>
#include <stop_token>

namespace innergs {

/// How to interpolate between the frames of a series, voxel by voxel.
enum class FrameMethod {
  Previous, // the last earlier frame
  Nearest,
  Linear,
  Cubic, // natural cubic spline through all frames
  Mean,  // mean over time
  Spline // smoothing spline; its smoothing chosen by holding out every 4th frame
};
const char* frameMethodName(FrameMethod method);

/// The interpolated volumes at times within the series. Non-finite voxels stay so where they contribute.
/// Throws Error(Cancelled).
std::vector<std::vector<float>> interpolateFrames(const TimeSeries& series, std::span<const double> times,
                                                  FrameMethod method, int threads = 0,
                                                  const std::stop_token& stop = {});

/// The frame at a time between its two neighbours, by registering them (ITK's symmetric-forces demons, after
/// Thirion 1998, at three resolutions), moving each its share of the displacement, and averaging. Throws
/// Error(Cancelled | Internal).
std::vector<float> demonsFrame(const TimeSeries& series, double time, const std::stop_token& stop = {});

} // namespace innergs
