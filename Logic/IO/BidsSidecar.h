#pragma once
#include "Core/Motion/SliceTiming.h"

#include <filesystem>
#include <optional>
#include <string>

namespace innergs {

struct GridGeometry;

/// The BIDS sidecar of an image: the same name with .json.
std::filesystem::path sidecarOf(const std::filesystem::path& image);

/// Slice times (s) of a frame on the lattice from text: one per slice, separated by blanks, commas or lines,
/// along a direction as BIDS names it ("k", "j-"; "": `axis`). Empty where all are equal. Throws
/// Error(FileFormat), which names `what`.
SliceTiming sliceTimingFrom(const std::string& text, const std::string& direction, int axis,
                            const GridGeometry& lattice, const std::string& what);

/// The same from a BIDS file (.json): SliceTiming and SliceEncodingDirection. Nothing where it has none, and
/// for what is no such file. Throws Error(FileFormat).
std::optional<SliceTiming> bidsSliceTiming(const std::filesystem::path& file, int axis,
                                           const GridGeometry& lattice);

/// The same from a file that someone chose: .json, or the text alone. Throws Error(FileNotFound |
/// FileFormat).
SliceTiming readSliceTiming(const std::filesystem::path& file, const GridGeometry& lattice, int axis = 2);

} // namespace innergs
