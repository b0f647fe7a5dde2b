#pragma once
#include "Core/Volume.h"

#include <itkImageIOBase.h>

#include <filesystem>
#include <string>

namespace innergs {

struct DicomSeries {
  Volume volume;             // slices ordered along the normal of the image plane
  double sliceThickness = 0; // mm, (0018,0050); 0 when absent
};

/// The one series in a folder. Throws Error(FileFormat) for a folder without or with several series (the
/// sentence lists them), Error(Geometry) for uneven or tilted slices, Error(UnsupportedImage) for colour or
/// several images per position.
DicomSeries readDicomSeries(const std::filesystem::path& folder);

/// Throws Error(FileFormat) when uncompressed pixel data end before their stated length: GDCM then reads what
/// there is.
void checkDicomPixels(const itk::ImageIOBase& io, const std::string& what);

} // namespace innergs
