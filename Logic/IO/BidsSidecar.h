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

/// What a BIDS file (.json) says of when a moving scan was acquired; empty and 0 where it says nothing.
struct BidsTimes {
  std::vector<double> frames; // s, VolumeTiming
  double interval = 0;        // s, RepetitionTime
  std::vector<double> slices; // s, SliceTiming
  std::string direction;      // SliceEncodingDirection
};

/// Nothing for what is no such file. Throws Error(FileFormat).
BidsTimes readBidsTimes(const std::filesystem::path& file);

/// Slice times (s) of a frame on the lattice from text: one per slice, separated by blanks, commas or lines,
/// along a direction as BIDS names it ("k", "j-"; "": `axis`). Empty where all are equal. Throws
/// Error(FileFormat), which names `what`.
SliceTiming sliceTimingFrom(const std::string& text, const std::string& direction, int axis,
                            const GridGeometry& lattice, const std::string& what);

/// The same from a BIDS file; nothing where it has none. Throws Error(FileFormat), which names `what`.
std::optional<SliceTiming> sliceTimingFrom(const BidsTimes& times, int axis, const GridGeometry& lattice,
                                           const std::string& what);
std::optional<SliceTiming> bidsSliceTiming(const std::filesystem::path& file, int axis,
                                           const GridGeometry& lattice);

/// The same from a file that someone chose: .json, or the text alone. Throws Error(FileNotFound |
/// FileFormat).
SliceTiming readSliceTiming(const std::filesystem::path& file, const GridGeometry& lattice, int axis = 2);

} // namespace innergs
