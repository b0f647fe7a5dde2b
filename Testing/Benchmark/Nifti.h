#pragma once
#include "Core/Image/Volume.h"

#include <string>

namespace innergs::bench {

/// Voxels and spacing of an uncompressed NIfTI-1 file of this machine's byte order (8 and 16-bit integers,
/// 32-bit floats), for builds without ITK; its place in the scanner is left out. Throws Error.
Volume readPlainNifti(const std::string& path);

} // namespace innergs::bench
