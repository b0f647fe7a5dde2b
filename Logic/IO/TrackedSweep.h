#pragma once
#include "Core/Image/Stack.h"

#include <filesystem>
#include <map>
#include <string>

namespace innergs {

/// Constant transforms between coordinate systems, named as in "ImageToProbe": pixels or mm to mm.
using NamedTransforms = std::map<std::string, Affine3>;

/// Reads the calibration of a tracked probe: the transforms in an XML configuration of PLUS or IGSIO, or a
/// text file of 16 numbers, ImageToProbe row by row. Throws Error(FileNotFound | FileFormat).
NamedTransforms readCalibration(const std::filesystem::path& path);

/// Whether the fields of a tracked sweep and the calibration tell where its images lie; if not, a sentence
/// why.
std::string whyNotPlaced(const std::map<std::string, std::string>& fields, const NamedTransforms& calibration,
                         const std::string& what);

/// Places the images of a tracked sweep, an IGSIO sequence: a pose for each of them that was tracked, from
/// its pixels to the system Reference (Patient, World, RAS or Tracker if there is none), which is taken for
/// RAS mm. The calibration goes before transforms of the same name in the file. Images whose transforms
/// or pixels are not valid are left out. A shear between rows and columns is resampled, and pixels more than
/// four times finer than the distance between images and the beam, taken to be 1 mm thick, are averaged.
/// Throws Error(UnsupportedImage) if it is not known where they lie, Error(FileFormat | Geometry) for
/// transforms that are damaged or not rigid.
Stack placedSweep(Volume images, const std::map<std::string, std::string>& fields,
                  const NamedTransforms& calibration, const std::string& what);

} // namespace innergs
