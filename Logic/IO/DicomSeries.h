#pragma once
#include "Core/Image/Volume.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace itk {
class ImageIOBase;
}

namespace innergs {

struct DicomSeries {
  Volume volume;                  // slices in order along the normal of the image plane
  double sliceThickness = 0;      // mm, (0018,0050); 0 when absent
  std::vector<double> sliceTimes; // s, of each slice; empty if absent or all equal
  std::vector<Affine3> poses;     // as Stack::poses: of slices that are not evenly spaced along their normal
  std::vector<std::string> remarks; // sentences on them for the user
};

/// One stack of a folder, with a description that distinguishes it from the others. Parts of a series that
/// differ in size, spacing, orientation, echo or time are separate stacks.
struct DicomEntry {
  std::string description; // (0008,103E), may be empty
  std::string detail;      // distinguishes it within its series: "echo time 80", or empty
  std::int64_t images = 0;
  std::array<std::int64_t, 2> size{};
  double thickness = 0;           // mm, 0 when absent
  std::string plane;              // the nearest one: "axial", "coronal", "sagittal"
  double tilt = 0;                // degrees between the slices and that plane
  std::vector<std::string> files; // UTF-8
};

/// Sorted by series number. Throws Error(FileFormat) if there is none.
std::vector<DicomEntry> listDicomSeries(const std::filesystem::path& folder);

/// "'T2 axial', 24 images of 512 x 512, axial tilted by 8 degrees, 4 mm thick".
std::string textOf(const DicomEntry& entry);

/// Reads a series of a folder, counted from 1 as listed; without a number, the only one. Throws
/// Error(FileFormat | InvalidArgument) if the folder has no series, several (without a number) or fewer (the
/// message lists them), Error(Geometry) for slices that are not parallel or seem to be missing,
/// Error(UnsupportedImage) for colour or for several images at one position. Parallel slices at other
/// distances, or displaced within their planes (a tilted gantry), get poses.
DicomSeries readDicomSeries(const std::filesystem::path& folder, std::optional<int> series = {});

/// Throws Error(FileFormat) if uncompressed pixel data end before their stated length; GDCM would silently
/// read what there is.
void checkDicomPixels(const itk::ImageIOBase& io, const std::string& what);

} // namespace innergs
