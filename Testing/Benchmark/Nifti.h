#pragma once
#include "Core/Image/Volume.h"

#include <string>

namespace innergs::bench {

/// Voxels and spacing of an uncompressed NIfTI-1 file in this machine's byte order (8 and 16-bit integers,
/// 32-bit floats), for builds without ITK; ignores its position in the scanner. Throws Error.
Volume readPlainNifti(const std::string& path);

} // namespace innergs::bench
