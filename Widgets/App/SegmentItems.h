#pragma once
#include "Text/SegmentFinder.h"
#include "Widgets/App/DataItems.h"

namespace innergs::app {

/// Segments as the slice views show them over a volume.
struct SegmentOverlay {
  vtkSmartPointer<vtkImageData> labels; // 1, 2, … as far as they reach; origin 0, spacing 1
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS;
  std::vector<std::array<double, 3>> colors; // of the labels 1, 2, …
};

/// Null where there is no voxel to show.
std::shared_ptr<const SegmentOverlay> overlayOf(const MadeSegments& made);

/// A labelmap (1, 2, …) of the segments on their whole grid; its file keeps their names where that can.
/// For worker threads. Throws Error as makeItem() does.
VolumeItem labelmapOf(const MadeSegments& made);

/// "liver", "liver and 2 more"
QString nameOf(const MadeSegments& made);

} // namespace innergs::app
