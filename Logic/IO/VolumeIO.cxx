#include "IO/VolumeIO.h"

#include "Core/Base/Error.h"
#include "Core/Image/SliceAxis.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/ImageReading.h"
#include "IO/TrackedSweep.h"
#include "IO/VoxelWriting.h"

#include <algorithm>
#include <cmath>

namespace innergs {

Volume readVolume(const std::filesystem::path& path, const ReadOptions& options) {
  LoadedImage loaded = loadImage(path, options);
  if (!loaded.poses.empty())
    throw Error(ErrorCode::Geometry, quoted(path) + " holds slices that are not evenly spaced along their "
                                                    "normal; reconstruct a volume from it first.");
  return std::move(loaded.volume);
}

Stack readStack(const std::filesystem::path& path, const ReadOptions& options) {
  LoadedImage loaded = loadImage(path, options);
  const int axis = loaded.slicesAreAlongK ? 2 : sliceAxisOf(loaded.volume.geometry.spacing);
  Stack stack;
  if (loaded.tracked) {
    stack = placedSweep(
        std::move(loaded.volume), loaded.sweepFields,
        options.calibration.empty() ? NamedTransforms{} : readCalibration(options.calibration), quoted(path));
  } else {
    stack.image = axis == 2 ? std::move(loaded.volume) : withSliceAxis(loaded.volume, axis);
    stack.poses = std::move(loaded.poses);
    stack.remarks = std::move(loaded.remarks);
  }
  if (stack.image.geometry.size[2] < 2)
    throw Error(
        ErrorCode::UnsupportedImage,
        quoted(path) + " has a single slice; at least two are needed" +
            (loaded.slicesAreAlongK ? " (give the folder with all slices of the DICOM series)." : "."));
  if (std::isfinite(loaded.sliceThickness) && loaded.sliceThickness > 0)
    stack.thickness = loaded.sliceThickness, stack.thicknessFrom = loaded.thicknessFrom;
  if (std::ssize(loaded.sliceTimes) == stack.image.geometry.size[2])
    stack.times = std::move(loaded.sliceTimes);
  const std::filesystem::path name =
      path.has_filename() ? path.filename() : path.parent_path().filename(); // "folder/" names the folder
  stack.name = utf8(name.empty() ? path : name);
  return stack;
}

Mask readMask(const std::filesystem::path& path) {
  const Volume volume = readVolume(path);
  Mask mask{volume.geometry, std::vector<std::uint8_t>(volume.voxels.size())};
  std::transform(volume.voxels.begin(), volume.voxels.end(), mask.voxels.begin(),
                 [](float value) { return static_cast<std::uint8_t>(value != 0 && !std::isnan(value)); });
  if (std::find(mask.voxels.begin(), mask.voxels.end(), 1) == mask.voxels.end())
    throw Error(ErrorCode::NoData,
                "The mask " + quoted(path) + " has no voxel inside; draw one or omit the mask.");
  return mask;
}

std::string writeVolume(const Volume& volume, const std::filesystem::path& path, OutputType type,
                        const std::optional<VoxelValues>& expected,
                        const std::map<std::string, std::string>& fields) {
  checkVoxelFormat(path);
  checkGeometry(volume.geometry, "The volume for " + quoted(path));
  if (static_cast<std::int64_t>(volume.voxels.size()) != volume.geometry.voxelCount())
    throw Error(ErrorCode::InvalidArgument,
                "The volume for " + quoted(path) + " has fewer or more voxels than its grid.");
  const TypedVoxels voxels(volume.voxels, type, expected, path);
  writeItkFile(path, volume.geometry, type, voxels, fields);
  return voxels.remark();
}

void checkVolumePath(const std::filesystem::path& path) {
  checkVoxelFormat(path);
  checkOutputFolder(path);
}

} // namespace innergs
