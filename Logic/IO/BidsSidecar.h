#pragma once
#include "Core/Motion/SliceTiming.h"

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace innergs {

struct GridGeometry;

/// The BIDS sidecar of an image: the same name with .json.
std::filesystem::path sidecarOf(const std::filesystem::path& image);

/// When a dynamic scan was acquired, according to a BIDS file (.json); empty and 0 where the file says
/// nothing.
struct BidsTimes {
  std::vector<double> frames; // s, VolumeTiming
  double interval = 0;        // s, RepetitionTime
  std::vector<double> slices; // s, SliceTiming
  std::string direction;      // SliceEncodingDirection
};

/// All empty for a file that is missing or no JSON object. Throws Error(FileFormat).
BidsTimes readBidsTimes(const std::filesystem::path& file);

/// What a BIDS file (.json) says of the slices of an image that does not move; 0 and empty where it says
/// nothing, or nothing that fits the grid.
struct BidsSlices {
  int axis = 2;              // grid axis that counts the slices
  double thickness = 0;      // mm, SliceThickness
  std::vector<double> times; // s, SliceTiming, of each slice along the axis
};

/// axis: counts the slices if the file has no SliceEncodingDirection.
BidsSlices readBidsSlices(const std::filesystem::path& file, int axis, const GridGeometry& grid);

/// Slice times (s) of a frame on the grid from text: one per slice, separated by blanks, commas or lines,
/// along a direction as BIDS names it ("k", "j-"; "": `axis`). Empty if all are equal. Throws
/// Error(FileFormat), naming `what`.
SliceTiming sliceTimingFrom(const std::string& text, const std::string& direction, int axis,
                            const GridGeometry& grid, const std::string& what);

/// The same from a BIDS file; nullopt if it has none. Throws Error(FileFormat), naming `what`.
std::optional<SliceTiming> sliceTimingFrom(const BidsTimes& times, int axis, const GridGeometry& grid,
                                           const std::string& what);
std::optional<SliceTiming> bidsSliceTiming(const std::filesystem::path& file, int axis,
                                           const GridGeometry& grid);

/// The same from a file that the user chose: .json or plain text. Throws Error(FileNotFound | FileFormat).
SliceTiming readSliceTiming(const std::filesystem::path& file, const GridGeometry& grid, int axis = 2);

} // namespace innergs
