#pragma once
#include "Core/Job/ReconstructionJob.h"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <string>
#include <vector>

namespace innergs::cli {

/// One row per slice: scan, slice (from 0), weight, gain, displacement (mm), angle (degrees), residual, and
/// the twelve numbers of slicePlace(), row by row.
std::string sliceTable(const ReconstructionResult& result);
/// The same for the report; null where slices were not looked at.
nlohmann::ordered_json slicesOf(const ReconstructionResult& result);

/// ITK's transform of one slice as text (.tfm): from where tissue is to where the scan's header puts it, as
/// ITK's resampling and Slicer read it.
std::string itkTransform(const Affine3& place);
/// Writes scan-1-slice-003.tfm and so on into a folder, which is made where it is missing. Throws Error(Io).
void writeTransforms(const ReconstructionResult& result, const std::filesystem::path& folder);

} // namespace innergs::cli
