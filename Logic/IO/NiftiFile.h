#pragma once
#include "Core/Image/Linear.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

namespace innergs {

/// The fields of a NIfTI-1 header that ITK's reader hides or silently repairs.
struct NiftiHeader {
  std::filesystem::path voxelFile; // the same file, or the .img of a pair
  bool swapped = false;            // of the other byte order
  int datatype = 0, bytesPerVoxel = 0;
  std::array<std::int64_t, 7> size{1, 1, 1, 1, 1, 1, 1};
  Vec3 spacing{1, 1, 1};        // as stored (header units)
  double frameSeconds = 0;      // from one frame to the next; 0: unknown
  double firstSeconds = 0;      // of the first frame (toffset)
  int intent = 0;               // what the values mean, NIfTI's code
  double millimetres = 1;       // one header unit of length in mm
  std::int64_t voxelOffset = 0; // bytes
  double slope = 1, intercept = 0;
  int qformCode = 0, sformCode = 0;
  Vec3 qformOffset{0, 0, 0};
  Affine3 sform; // index → RAS, header units
};

/// The header of a .nii, .nii.gz or .hdr file. Throws Error(FileFormat | Geometry | UnsupportedImage) when it
/// is not NIfTI-1, is truncated, has a spacing that is not positive, or is sheared.
NiftiHeader readNiftiHeader(const std::filesystem::path& path);

/// ITK leaves the origin in the header's unit of length when that is not mm; `origin` is ITK's.
Vec3 originInMillimetres(const NiftiHeader& header, const Vec3& origin);

/// Voxels of `count` frames from `first` on, slope and intercept applied. niftilib, below ITK, turns NaN and
/// infinity into 0; this keeps them.
std::vector<std::vector<float>> readNiftiFrames(const NiftiHeader& header, std::int64_t first,
                                                std::int64_t count, const std::filesystem::path& path);

} // namespace innergs
