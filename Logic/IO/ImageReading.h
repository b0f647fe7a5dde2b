#pragma once
#include "IO/VolumeIO.h"

namespace innergs {

/// An image file or DICOM folder as one scalar volume with checked geometry.
struct LoadedImage {
  Volume volume;
  double sliceThickness = 0;    // mm, 0 when the file does not say
  bool slicesAreAlongK = false; // known from the file (DICOM)
  std::int64_t frames = 1;      // that the file holds
  double frameSeconds = 0;      // from one frame to the next, 0 when the file does not say
  bool tracked = false;         // a sweep of 2D images that lie freely in space; their places are not used
};

/// See readVolume.
LoadedImage loadImage(const std::filesystem::path& path, const ReadOptions& options);

} // namespace innergs
