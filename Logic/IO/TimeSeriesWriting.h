#pragma once
#include "Core/Motion/TimeSeries.h"
#include "IO/OutputType.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace innergs {

/// Writes 4D NIfTI (.nii, .nii.gz) or 3D Slicer's .seq.nrrd, atomically. NIfTI stores a single interval
/// between frames; uneven times go to a .json with VolumeTiming beside it. Returns a sentence if values were
/// clipped, else "". Throws Error(Io | InvalidArgument).
std::string writeTimeSeries(const TimeSeries& series, const std::filesystem::path& path,
                            OutputType type = OutputType::Float32,
                            const std::optional<VoxelValues>& expected = {});

/// Whether writeTimeSeries() writes a sidecar for frames at these times.
bool needsSidecar(const std::filesystem::path& path, const std::vector<double>& times);

/// Throws Error(InvalidArgument | Io) if writeTimeSeries could not write `path`.
void checkTimeSeriesPath(const std::filesystem::path& path);

} // namespace innergs
