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

/// All frames of an image file, as they lie in it.
struct LoadedFrames {
  GridGeometry geometry; // checked
  std::vector<std::vector<float>> frames;
  double frameSeconds = 0,
         firstSeconds = 0;          // from one frame to the next (0: the file does not say), and of the first
  std::string indexName, indexUnit; // of a list of frames (.seq.nrrd)
  std::vector<double> indexValues;
  bool vectors = false; // the file says that the values of a voxel belong together and are no frames
};

/// Throws as readVolume does.
LoadedFrames loadFrames(const std::filesystem::path& path);

/// An image with any number of values per voxel.
struct VectorImage {
  GridGeometry geometry; // checked
  std::vector<std::vector<float>> components;
};

/// A file's vectors or frames as components. Throws as readVolume does.
VectorImage loadVectors(const std::filesystem::path& path);

/// See readVolume.
LoadedImage loadImage(const std::filesystem::path& path, const ReadOptions& options);

} // namespace innergs
