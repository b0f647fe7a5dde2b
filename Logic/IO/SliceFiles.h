#pragma once
#include "Core/Job/FoundSlices.h"

#include <filesystem>
#include <span>
#include <string>

/// Writes files that say where the slices of several scans were found to lie.
namespace innergs {

/// TSV, one row per slice: scan (from 1), slice (from 0), weight, gain, displacement (mm), angle (degrees),
/// residual, and the twelve numbers of its place (LPS mm), row by row.
std::string sliceTable(std::span<const FoundSlice> slices);

/// The ITK transform of one slice as text (.tfm): maps where the tissue is to where the scan's header puts
/// it, the direction that ITK's resampling and Slicer expect.
std::string itkTransform(const Affine3& place);
/// Writes scan-1-slice-003.tfm and so on to a folder, which is created if missing. Throws Error(Io).
void writeTransforms(std::span<const FoundSlice> slices, const std::filesystem::path& folder);

} // namespace innergs
