#pragma once
#include "Core/Motion/TimeSeries.h"
#include "IO/OutputType.h"

#include <filesystem>
#include <optional>

namespace innergs {

struct TimeSeriesOptions {
  std::vector<double> times; // s, one per frame; empty: from the file
  std::optional<double>
      interval; // s, from one frame to the next, where the file does not say or says it wrongly
};

/// Reads a moving scan: 4D NIfTI or MINC2, 3D Slicer's .seq.nrrd, or a folder with one image per frame, in
/// the order of their names (numbers by value). Times in seconds come from the options, from what lies beside
/// the image (BIDS's .json with VolumeTiming or RepetitionTime; in a folder times.txt, one number a line), or
/// from the file's own header and its unit. Throws Error(FileNotFound | FileFormat | UnsupportedImage |
/// Geometry | InvalidArgument | NoData) with one sentence: one frame, frames of different lattices, times
/// that are missing or do not increase, frames that are all equal, colour, vectors and diffusion.
TimeSeries readTimeSeries(const std::filesystem::path& path, const TimeSeriesOptions& options = {});

/// A sentence where the frames look as if they were acquired in turn under two conditions (label and
/// control), so that they are no course of time; else "".
std::string remarkOnPairs(const TimeSeries& series);

/// Writes 4D NIfTI (.nii, .nii.gz) or 3D Slicer's .seq.nrrd, beside the target first and then renamed. NIfTI
/// knows one distance between frames; where the times are not even, they go beside it as a .json with
/// VolumeTiming. Returns a sentence where values were cut off, else "". Throws Error(Io | InvalidArgument).
std::string writeTimeSeries(const TimeSeries& series, const std::filesystem::path& path,
                            OutputType type = OutputType::Float32,
                            const std::optional<VoxelValues>& expected = {});

/// What stands beside an image and says more of it (BIDS): the same name with .json.
std::filesystem::path sidecarOf(const std::filesystem::path& image);
/// Whether writeTimeSeries() writes such a file for frames at these times.
bool needsSidecar(const std::filesystem::path& path, const std::vector<double>& times);

/// Throws Error(InvalidArgument | Io) when `path` could not be written by writeTimeSeries.
void checkTimeSeriesPath(const std::filesystem::path& path);

} // namespace innergs
