#include "PlaneIn3D.h"

#include <vtkMRMLModelDisplayNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>

#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkImageMapToWindowLevelColors.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

namespace {

/// The picture's rectangle, to the edges of its pixels.
vtkSmartPointer<vtkPolyData> rectangleOf(const innergs::ui::PlaneImage& picture) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> texture;
  texture->SetNumberOfComponents(2);
  for (const auto& [u, v] : {std::pair{0., 0.}, {1., 0.}, {1., 1.}, {0., 1.}}) {
    double at[4] = {u * picture.task.columns - 0.5, v * picture.task.rows - 0.5, 0, 1};
    picture.ijkToRAS->MultiplyPoint(at, at);
    points->InsertNextPoint(at);
    texture->InsertNextTuple2(u, v);
  }
  vtkNew<vtkCellArray> cells;
  const vtkIdType corners[4] = {0, 1, 2, 3};
  cells->InsertNextCell(4, corners);
  auto rectangle = vtkSmartPointer<vtkPolyData>::New();
  rectangle->SetPoints(points);
  rectangle->SetPolys(cells);
  rectangle->GetPointData()->SetTCoords(texture);
  return rectangle;
}

vtkMRMLModelNode* addHidden(vtkMRMLScene* scene) {
  vtkNew<vtkMRMLModelNode> node;
  vtkNew<vtkMRMLModelDisplayNode> display;
  node->SetName("InnerGS plane");
  node->SetHideFromEditors(1);
  node->SetSelectable(0);
  for (vtkMRMLNode* one : {static_cast<vtkMRMLNode*>(node), static_cast<vtkMRMLNode*>(display)}) {
    one->SetSaveWithScene(0);
    one->UndoEnabledOff();
  }
  display->SetHideFromEditors(1);
  display->SetColor(1, 1, 1);
  display->SetAmbient(1);
  display->SetDiffuse(0);
  display->SetSpecular(0);
  display->SetBackfaceCulling(0);
  display->SetVisibility2D(0);
  display->SetInterpolateTexture(1);
  scene->AddNode(display);
  scene->AddNode(node);
  node->SetAndObserveDisplayNodeID(display->GetID());
  return node;
}

} // namespace

PlaneIn3D::PlaneIn3D() {
  colours_->SetOutputFormatToRGB();
}

PlaneIn3D::~PlaneIn3D() {
  remove();
}

void PlaneIn3D::remove() {
  if (!scene_ || !node_ || node_->GetScene() != scene_) return;
  const vtkSmartPointer<vtkMRMLNode> display = node_->GetDisplayNode();
  scene_->RemoveNode(node_);
  if (display && display->GetScene()) scene_->RemoveNode(display);
}

void PlaneIn3D::setScene(vtkMRMLScene* scene) {
  if (scene == scene_) return;
  remove();
  scene_ = scene;
}

void PlaneIn3D::setShown(bool shown) {
  shown_ = shown;
  update();
}

void PlaneIn3D::setPicture(const innergs::ui::PlaneImage& picture) {
  picture_ = picture;
  if (shown_) update();
}

void PlaneIn3D::setWindow(double lower, double upper) {
  lower_ = lower;
  upper_ = upper;
  if (shown_) update();
}

void PlaneIn3D::update() {
  if (!scene_ || scene_->IsClosing()) return;
  if (!shown_ || !picture_.image) return remove();
  if (!node_ || node_->GetScene() != scene_) node_ = addHidden(scene_);
  colours_->SetInputData(picture_.image);
  colours_->SetWindow(upper_ - lower_);
  colours_->SetLevel((upper_ + lower_) / 2);
  colours_->Update();
  MRMLNodeModifyBlocker blocker(node_);
  node_->SetAndObservePolyData(rectangleOf(picture_));
  vtkMRMLDisplayNode* display = node_->GetDisplayNode();
  if (!display) return;
  display->SetTextureImageDataConnection(colours_->GetOutputPort());
  display->Modified(); // the texture, in 3D views
}
