#pragma once
#include "Core/Motion/TimeSeries.h"
#include "IO/BidsSidecar.h"

#include <filesystem>
#include <optional>

namespace innergs {

struct TimeSeriesOptions {
  std::vector<double> times;          // s, one per frame; empty: as in the file
  std::optional<double> interval;     // s between frames, if the file does not say or is wrong
  std::filesystem::path sliceTimes{}; // file for readSliceTiming(); empty: as the scan says
};

/// Reads a dynamic scan: 4D NIfTI or MINC2, 3D Slicer's .seq.nrrd, or a folder with one image per frame in
/// natural order of the names. Times in seconds come from the options, from a file beside the image (BIDS's
/// .json with VolumeTiming or RepetitionTime; in a folder times.txt, one number per line), or from the file's
/// header and its unit; the times of a frame's slices likewise, or from that .json (SliceTiming,
/// SliceEncodingDirection) or the NIfTI header (slice_code). Throws Error(FileNotFound | FileFormat |
/// UnsupportedImage | Geometry | InvalidArgument | NoData) with one sentence: a single frame, frames on
/// different grids, times that are missing or do not increase, frames that are all equal, colour, vectors
/// and diffusion.
TimeSeries readTimeSeries(const std::filesystem::path& path, const TimeSeriesOptions& options = {});

/// The images of a folder with a times.txt, one per frame, in natural order of the names; empty for anything
/// else.
std::vector<std::filesystem::path> frameFiles(const std::filesystem::path& folder);

/// A sentence if the frames look like two alternating conditions (label and control) rather than a course in
/// time; else "".
std::string remarkOnPairs(const TimeSeries& series);

} // namespace innergs
