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

#include <utility>
#include <vector>

namespace {

using Point = std::array<double, 3>;

/// The part of a convex polygon on one side of `at` along an axis.
std::vector<Point> cut(const std::vector<Point>& polygon, int axis, double at, double side) {
  std::vector<Point> rest;
  for (std::size_t n = 0; n < polygon.size(); ++n) {
    const Point &a = polygon[n], &b = polygon[(n + 1) % polygon.size()];
    const double da = side * (a[axis] - at), db = side * (b[axis] - at);
    if (da >= 0) rest.push_back(a);
    if ((da > 0 && db < 0) || (da < 0 && db > 0)) {
      Point between;
      for (int i = 0; i < 3; ++i)
        between[i] = a[i] + da / (da - db) * (b[i] - a[i]);
      rest.push_back(between);
    }
  }
  return rest;
}

/// The part of the picture inside the model's box, with its texture coordinates.
vtkSmartPointer<vtkPolyData> polygonOf(const innergs::ui::PlaneImage& picture,
                                       const std::array<double, 6>& bounds) {
  const double size[2] = {double(picture.task.columns), double(picture.task.rows)};
  std::vector<Point> corners;
  for (const auto& [u, v] : {std::pair{0., 0.}, {1., 0.}, {1., 1.}, {0., 1.}}) {
    double at[4] = {u * size[0] - 0.5, v * size[1] - 0.5, 0, 1}; // the outer edges of its pixels
    picture.ijkToRAS->MultiplyPoint(at, at);
    corners.push_back({at[0], at[1], at[2]});
  }
  for (int axis = 0; axis < 3; ++axis) {
    corners = cut(corners, axis, bounds[2 * axis] - 0.5 * picture.task.pixelSize, 1);
    corners = cut(corners, axis, bounds[2 * axis + 1] + 0.5 * picture.task.pixelSize, -1);
  }
  vtkNew<vtkMatrix4x4> toPixels;
  vtkMatrix4x4::Invert(picture.ijkToRAS, toPixels);
  vtkNew<vtkPoints> points;
  vtkNew<vtkFloatArray> texture;
  texture->SetNumberOfComponents(2);
  vtkNew<vtkCellArray> cells;
  if (corners.size() >= 3) cells->InsertNextCell(static_cast<int>(corners.size()));
  for (const Point& corner : corners) {
    double at[4] = {corner[0], corner[1], corner[2], 1};
    const vtkIdType n = points->InsertNextPoint(at);
    if (corners.size() >= 3) cells->InsertCellPoint(n);
    toPixels->MultiplyPoint(at, at);
    texture->InsertNextTuple2((at[0] + 0.5) / size[0], (at[1] + 0.5) / size[1]);
  }
  auto polygon = vtkSmartPointer<vtkPolyData>::New();
  polygon->SetPoints(points);
  polygon->SetPolys(cells);
  polygon->GetPointData()->SetTCoords(texture);
  return polygon;
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

void PlaneIn3D::setPicture(const innergs::ui::PlaneImage& picture, const std::array<double, 6>& bounds) {
  picture_ = picture;
  bounds_ = bounds;
  if (shown_) update();
}

void PlaneIn3D::setWindow(double lower, double upper) {
  lower_ = lower;
  upper_ = upper;
  if (shown_) update();
}

void PlaneIn3D::update() {
  if (!scene_ || scene_->IsClosing()) return;
  if (!shown_ || !picture_.shown()) return remove();
  if (!node_ || node_->GetScene() != scene_) node_ = addHidden(scene_);
  colours_->SetInputData(picture_.shown());
  colours_->SetWindow(upper_ - lower_);
  colours_->SetLevel((upper_ + lower_) / 2);
  colours_->Update();
  MRMLNodeModifyBlocker blocker(node_);
  node_->SetAndObservePolyData(polygonOf(picture_, bounds_));
  vtkMRMLDisplayNode* display = node_->GetDisplayNode();
  if (!display) return;
  display->SetTextureImageDataConnection(colours_->GetOutputPort());
  display->Modified(); // for the texture in 3D views
}
