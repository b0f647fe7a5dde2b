#pragma once
#include "Core/Image/GridGeometry.h"

#include <filesystem>
#include <vector>

namespace innergs {

/// Displacements of a dynamic scan, as defined in Core/Motion/MotionField.h: mm, LPS, three per voxel.
struct MotionSequence {
  GridGeometry geometry;
  std::vector<double> times;              // s
  std::vector<std::vector<float>> fields; // one per time
};

/// The files that writeMotion() writes: one .seq.nrrd, or for .nrrd, .nii, .nii.gz and .mha one per time,
/// numbered before the extension ("motion-000.nrrd") unless there is only one. Throws Error(InvalidArgument)
/// for other extensions.
std::vector<std::filesystem::path> motionFiles(const std::filesystem::path& path, std::size_t times);

/// ITK's displacement fields: images of vectors. A .seq.nrrd holds all (axes: vector, I, J, K, time). Throws
/// Error(Io | InvalidArgument).
void writeMotion(const MotionSequence& motion, const std::filesystem::path& path);

} // namespace innergs
