#pragma once
#include "IO/VolumeIO.h"

namespace innergs {

/// An image file or DICOM folder, read as one scalar volume with checked geometry.
struct LoadedImage {
  Volume volume;
  double sliceThickness = 0;      // mm, 0 if the file does not say
  bool slicesAreAlongK = false;   // the file defines the slice axis (DICOM)
  std::int64_t frames = 1;        // number of frames in the file
  double frameSeconds = 0;        // time between frames, 0 if the file does not say
  bool tracked = false;           // a sweep of freely positioned 2D images, as parallel slices here
  std::string thicknessFrom;      // where the thickness is said, e.g. "DICOM (0018,0050)"
  std::vector<double> sliceTimes; // s, of each slice along the axis of readStack(); empty: not said
  std::map<std::string, std::string> sweepFields; // of a tracked sweep, see placedSweep()
  std::vector<Affine3>
      poses; // of DICOM slices that are not evenly spaced along their normal, as Stack::poses
  std::vector<std::string> remarks; // sentences on them
};

/// All frames of an image file, unconverted.
struct LoadedFrames {
  GridGeometry geometry; // checked
  std::vector<std::vector<float>> frames;
  double frameSeconds = 0,
         firstSeconds = 0;          // between frames (0: the file does not say), and of the first frame
  std::string indexName, indexUnit; // for a list of frames (.seq.nrrd)
  std::vector<double> indexValues;
  int sliceAxis = -1;               // index axis that counts the slices; -1: the file does not say
  std::vector<double> sliceSeconds; // s after the frame's start, of each slice; empty: the file does not say
  bool vectors = false; // the file says that a voxel's values belong together, so they are not frames
};

/// Throws like readVolume.
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
