#pragma once
#include "Core/Model/GaussianField.h"

#include <filesystem>
#include <string>

namespace innergs {

/// Writes a binary little-endian PLY file with the property names of 3D Gaussian splatting: x y z (LPS mm) nx
/// ny nz f_dc_0..2 opacity (logit) scale_0..2 (ln mm) rot_0..3 (w x y z). What those cannot hold (blending,
/// weight beyond the logit's range, slopes, frame, intensity map, value range, domain) goes into extra
/// properties and `comment innergs` lines that other readers ignore. For what is lost, see droppedByPly().
void writePly(const GaussianField& field, const std::filesystem::path& path);

/// What a PLY file of a field leaves out (the residual grid, a mask, the names of the segments that its
/// Gaussians have features of), as a sentence with numbers; "" if it keeps everything.
std::string droppedByPly(const GaussianField& field, int segments = 0);

/// Whether a file is read as a PLY file: by its extension or its first bytes.
bool isPly(const std::filesystem::path& path);

/// Reads PLY files of InnerGS exactly, and plain 3DGS files as far as their properties allow. Throws
/// Error(FileNotFound | FileFormat).
GaussianField readPly(const std::filesystem::path& path);

} // namespace innergs
