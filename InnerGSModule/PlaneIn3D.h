#pragma once
#include "Widgets/PlaneWorker.h"

#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <array>

class vtkImageMapToWindowLevelColors;
class vtkMRMLModelNode;
class vtkMRMLScene;

/// The query panel's plane in the 3D views: a hidden model node with the plane's picture on it, which is not
/// saved.
class PlaneIn3D {
public:
  PlaneIn3D();
  ~PlaneIn3D();
  void setScene(vtkMRMLScene* scene);
  /// Whether it is to be seen; without a picture nothing is.
  void setShown(bool shown);
  /// bounds: the model's (RAS mm), outside of which nothing is shown.
  void setPicture(const innergs::ui::PlaneImage& picture, const std::array<double, 6>& bounds);
  /// What is black and white, scanner units.
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
