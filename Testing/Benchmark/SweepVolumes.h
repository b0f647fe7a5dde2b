#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace innergs::bench {

/// The middle 80³ voxels of a volume (or fewer, if it is smaller) as seen along one of its axes, blurred
/// along it.
struct SweepVolume {
  std::string name; // "axis-0-blur-2"
  std::filesystem::path path;
};

/// For each axis, unblurred and blurred by a Gaussian with σ of 1 and 2 slices; writes them to `folder`.
/// Throws Error.
std::vector<SweepVolume> makeSweepVolumes(const std::filesystem::path& volume,
                                          const std::filesystem::path& folder);

} // namespace innergs::bench
