#pragma once
#include "Core/Image/Stack.h"
#include "IO/OutputType.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace innergs {

struct ReadOptions {
  std::optional<int> frame =
      std::nullopt; // which frame of a 4D file (0 = first); unset: a 4D file is refused
  std::optional<int> series =
      std::nullopt; // which series of a DICOM folder (1 = first); unset: several are refused
};

/// Reads NIfTI, NRRD/NHDR, MHA/MHD, MINC2 or a folder with DICOM series, in scanner units with exact LPS
/// geometry. Throws Error with one sentence: FileNotFound, FileFormat, UnsupportedImage, Geometry.
Volume readVolume(const std::filesystem::path& path, const ReadOptions& options = {});

/// The same as a stack to fit (at least two slices); the slice axis is K, or the axis with the coarsest
/// spacing when it is clearly coarser (then the lattice is permuted, in the same patient position). DICOM's
/// SliceThickness is used when present. A tracked sweep is an Error(UnsupportedImage).
Stack readStack(const std::filesystem::path& path, const ReadOptions& options = {});

/// A label image or mask: every voxel that is not 0 is inside. Throws Error(NoData) when empty.
Mask readMask(const std::filesystem::path& path);

/// Writes NIfTI (.nii, .nii.gz), NRRD (.nrrd) or MetaImage (.mha), beside the target first and then renamed.
/// NIfTI keeps its geometry in single precision, the others in double.
/// An integer type must suit `expected`, what the volume was made from, or without it the volume itself, as
/// checkType() says. Returns a sentence where values were cut off, but for the slight overshoot of what was
/// expected to fit; else "". Throws Error(Io | InvalidArgument).
std::string writeVolume(const Volume& volume, const std::filesystem::path& path,
                        OutputType type = OutputType::Float32,
                        const std::optional<VoxelValues>& expected = {},
                        const std::map<std::string, std::string>& fields = {});

/// Throws Error(InvalidArgument | Io) when `path` could not be written by writeVolume / as a file: unknown
/// extension, no such folder. To be called before the work starts.
void checkVolumePath(const std::filesystem::path& path);
void checkOutputFolder(const std::filesystem::path& path);

} // namespace innergs
