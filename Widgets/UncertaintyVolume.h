#pragma once
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkSmartPointer.h>

namespace innergs::ui {

/// The standard deviation of a model's volume (UncertaintyImage.h), in the model's own RAS. Never changes, so
/// that other threads may read it.
struct UncertaintyVolume {
  vtkSmartPointer<vtkImageData> image;
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // mm
  double usual = 1;                       // scanner units: few voxels exceed it
};

} // namespace innergs::ui
