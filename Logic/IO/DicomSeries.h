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
  Volume volume;             // slices ordered along the normal of the image plane
  double sliceThickness = 0; // mm, (0018,0050); 0 when absent
};

/// One stack of a folder, described so that people can tell it from the others. Parts of a series that differ
/// in size, spacing, orientation, echo or time are stacks of their own.
struct DicomEntry {
  std::string description; // (0008,103E), may be empty
  std::string detail;      // tells it from others of its series: "echo time 80", or empty
  std::int64_t images = 0;
  std::array<std::int64_t, 2> size{};
  double thickness = 0;           // mm, 0 when absent
  std::string plane;              // the nearest: "axial", "coronal", "sagittal"
  double tilt = 0;                // degrees, of the slices against that plane
  std::vector<std::string> files; // UTF-8
};

/// By series number. Throws Error(FileFormat) when there is none.
std::vector<DicomEntry> listDicomSeries(const std::filesystem::path& folder);

/// "'T2 axial', 24 images of 512 x 512, axial tilted by 8 degrees, 4 mm thick".
std::string textOf(const DicomEntry& entry);

/// A series of a folder, from 1 as listed; without a number its only one. Throws Error(FileFormat |
/// InvalidArgument) for a folder without or with several series or with fewer (the sentence lists them),
/// Error(Geometry) for uneven or tilted slices, Error(UnsupportedImage) for colour or several images per
/// position.
DicomSeries readDicomSeries(const std::filesystem::path& folder, std::optional<int> series = {});

/// Throws Error(FileFormat) when uncompressed pixel data end before their stated length: GDCM would read
/// what there is.
void checkDicomPixels(const itk::ImageIOBase& io, const std::string& what);

} // namespace innergs
