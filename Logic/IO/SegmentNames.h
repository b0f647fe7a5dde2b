#pragma once
#include "Core/Features/FeatureTraining.h"

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace innergs {

/// The names of a labelmap's segments: from a JSON file ({"1": "liver"} or {"liver": 1}), or from the header
/// of a segmentation written by 3D Slicer (.seg.nrrd). Empty for other images. Throws Error(FileNotFound |
/// FileFormat), and Error(UnsupportedImage) for a segmentation with overlapping segments.
std::vector<SegmentName> readSegmentNames(const std::filesystem::path& path);

/// A segment as stored by 3D Slicer.
struct SegmentInfo {
  SegmentName name;
  std::string terminology;                    // entry as 3D Slicer serialises it; empty: not known
  std::array<double, 3> color{0.5, 0.7, 0.5}; // red, green, blue from 0 to 1
};

/// Header fields that make a labelmap on the grid a 3D Slicer segmentation when written as .seg.nrrd.
std::map<std::string, std::string> segmentFields(const std::vector<SegmentInfo>& segments,
                                                 const GridGeometry& geometry);

} // namespace innergs
