#pragma once
#include "Core/Job/FoundSlices.h"

#include <filesystem>
#include <span>
#include <string>

/// Where the slices of several scans were found to lie, as files.
namespace innergs {

/// TSV, one row per slice: scan (from 1), slice (from 0), weight, gain, displacement (mm), angle (degrees),
/// residual, and the twelve numbers of its place (LPS mm), row by row.
std::string sliceTable(std::span<const FoundSlice> slices);

/// ITK's transform of one slice as text (.tfm): from where tissue is to where the scan's header puts it, as
/// ITK's resampling and Slicer read it.
std::string itkTransform(const Affine3& place);
/// Writes scan-1-slice-003.tfm and so on into a folder, which is made where it is missing. Throws Error(Io).
void writeTransforms(std::span<const FoundSlice> slices, const std::filesystem::path& folder);

} // namespace innergs
