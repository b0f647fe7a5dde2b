#pragma once
#include "Widgets/PlaneWorker.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <array>

class vtkImageMapToWindowLevelColors;
class vtkMRMLModelNode;
class vtkMRMLScene;

/// The query panel's plane in the 3D views: a hidden, unsaved model node, textured with the plane's picture.
class PlaneIn3D {
public:
  PlaneIn3D();
  ~PlaneIn3D();
  void setScene(vtkMRMLScene* scene);
  /// Shows or hides it; without a picture, nothing is shown.
  void setShown(bool shown);
  /// bounds: of the model (RAS mm); the picture is clipped to them.
  void setPicture(const innergs::ui::PlaneImage& picture, const std::array<double, 6>& bounds);
  /// The intensities shown as black and white, scanner units.
  void setWindow(double lower, double upper);

private:
  void update();
  void remove();

  vtkWeakPointer<vtkMRMLScene> scene_;
  vtkWeakPointer<vtkMRMLModelNode> node_;
  innergs::ui::PlaneImage picture_;
  std::array<double, 6> bounds_{};
  double lower_ = 0, upper_ = 1;
  bool shown_ = false;
  vtkNew<vtkImageMapToWindowLevelColors> colours_;
};
