#pragma once
#include "Core/Image/Stack.h"
#include "IO/OutputType.h"

#include <filesystem>
#include <map>
#include <optional>
#include <string>

namespace innergs {

struct ReadOptions {
  std::optional<int> frame = std::nullopt; // frame of a 4D file (0 = first); unset: 4D files are rejected
  std::optional<int> series =
      std::nullopt; // series of a DICOM folder (1 = first); unset: several series are rejected
  std::filesystem::path calibration = {}; // of tracked sweeps, see readCalibration()
};

/// Reads NIfTI, NRRD/NHDR, MHA/MHD, MINC2 or a folder with DICOM series, in scanner units with exact LPS
/// geometry. A tracked sweep is read as parallel slices. Throws Error with one sentence: FileNotFound,
/// FileFormat, UnsupportedImage, Geometry (also for DICOM slices that need poses).
Volume readVolume(const std::filesystem::path& path, const ReadOptions& options = {});

/// Like readVolume(), as a stack to fit (at least two slices). The slice axis is K, or the axis with the
/// coarsest spacing if it is clearly coarser (then the axes are permuted, at the same patient position).
/// Slice thickness and times are those of DICOM, NRRD (thicknesses), MetaImage (ElementSize), NIfTI
/// (slice_code) or of the BIDS file beside a NIfTI, if said. Slices of a tilted gantry, at uneven distances
/// or of a tracked sweep get poses, and remarks say so; a sweep needs its calibration, in the file or given.
Stack readStack(const std::filesystem::path& path, const ReadOptions& options = {});

/// A labelmap or mask: every non-zero voxel is inside. Throws Error(NoData) if empty.
Mask readMask(const std::filesystem::path& path);

/// Writes NIfTI (.nii, .nii.gz), NRRD (.nrrd) or MetaImage (.mha) atomically. NIfTI stores its geometry in
/// single precision, the others in double.
/// An integer type must suit `expected` (what the volume was made from) or, without it, the volume itself,
/// see checkType(). Returns a sentence if values were clipped beyond the slight overshoot of expected values;
/// else "". Throws Error(Io | InvalidArgument).
std::string writeVolume(const Volume& volume, const std::filesystem::path& path,
                        OutputType type = OutputType::Float32,
                        const std::optional<VoxelValues>& expected = {},
                        const std::map<std::string, std::string>& fields = {});

/// Throws Error(InvalidArgument | Io) if `path` could not be written by writeVolume: unknown extension, no
/// such folder. Call it before the work starts.
void checkVolumePath(const std::filesystem::path& path);

} // namespace innergs
