#pragma once
#include "Core/Image/Linear.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace innergs {

/// Fields of a NIfTI-1 header that ITK's reader hides or silently repairs.
struct NiftiHeader {
  std::filesystem::path voxelFile; // the same file, or the .img of a pair
  bool swapped = false;            // the other byte order
  int datatype = 0, bytesPerVoxel = 0;
  std::array<std::int64_t, 7> size{1, 1, 1, 1, 1, 1, 1};
  Vec3 spacing{1, 1, 1};            // as stored (header units)
  double frameSeconds = 0;          // between frames; 0: unknown
  double firstSeconds = 0;          // of the first frame (toffset)
  int sliceAxis = -1;               // index axis that counts the slices (dim_info); -1: unknown
  std::vector<double> sliceSeconds; // s after the frame's start, of each slice; empty: unknown
  int intent = 0;                   // NIfTI's code for the meaning of the values
  double millimetres = 1;           // mm per header unit of length
  std::int64_t voxelOffset = 0;     // bytes
  double slope = 1, intercept = 0;
  int qformCode = 0, sformCode = 0;
  Vec3 qformOffset{0, 0, 0};
  Affine3 sform; // index → RAS, header units
};

/// Reads the header of a .nii, .nii.gz or .hdr file. Throws Error(FileFormat | Geometry | UnsupportedImage)
/// if it is not NIfTI-1, truncated, sheared, or has a spacing that is not positive.
NiftiHeader readNiftiHeader(const std::filesystem::path& path);

/// The origin in mm; ITK leaves it in the header's unit of length. `origin`: ITK's.
Vec3 originInMillimetres(const NiftiHeader& header, const Vec3& origin);

/// Reads the voxels of `count` frames starting at `first`, with slope and intercept applied. Keeps NaN and
/// infinity, which niftilib (below ITK) turns into 0.
std::vector<std::vector<float>> readNiftiFrames(const NiftiHeader& header, std::int64_t first,
                                                std::int64_t count, const std::filesystem::path& path);

} // namespace innergs
