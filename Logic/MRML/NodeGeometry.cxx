#include "NodeGeometry.h"

#include "Core/Base/Error.h"
#include "Core/Image/SliceAxis.h"
#include "Geometry.h"

#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLTransformNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkImageData.h>

namespace innergs::mrml {

std::string nameOf(vtkMRMLNode* node, const std::string& otherwise) {
  return node && node->GetName() ? node->GetName() : otherwise;
}

std::string quoted(vtkMRMLNode* node) {
  return "'" + nameOf(node) + "'";
}

void toWorld(vtkMRMLTransformableNode* node, vtkMatrix4x4* nodeToWorld) {
  nodeToWorld->Identity();
  vtkMRMLTransformNode* parent = node->GetParentTransformNode();
  if (!parent) return;
  if (!parent->IsTransformToWorldLinear())
    throw Error(ErrorCode::Geometry, quoted(node) + " is under a transform that bends space (" +
                                         quoted(parent) + "): harden it on the volume first.");
  // A linear transform that is not invertible may be stored as its inverse only.
  if (!parent->GetMatrixTransformToWorld(nodeToWorld) || !(std::abs(nodeToWorld->Determinant()) > 1e-9) ||
      !std::isfinite(nodeToWorld->Determinant()))
    throw Error(ErrorCode::Geometry, quoted(node) + " is under a transform that cannot be inverted (" +
                                         quoted(parent) + "): correct or remove it.");
}

void ijkToWorld(vtkMRMLVolumeNode* node, vtkMatrix4x4* ijkToWorld) {
  vtkNew<vtkMatrix4x4> nodeToWorld, ijkToNode;
  toWorld(node, nodeToWorld);
  node->GetIJKToRASMatrix(ijkToNode);
  vtkMatrix4x4::Multiply4x4(nodeToWorld, ijkToNode, ijkToWorld);
}

GridGeometry gridOf(vtkMRMLVolumeNode* node) {
  vtkImageData* image = node->GetImageData();
  if (!image || image->GetNumberOfPoints() == 0)
    throw Error(ErrorCode::NoData, quoted(node) + " has no voxels: load or choose another volume.");
  vtkNew<vtkMatrix4x4> matrix;
  ijkToWorld(node, matrix);
  return vtk::gridOf(image, matrix, quoted(node));
}

GridGeometry boxOf(vtkMRMLMarkupsROINode* roi) {
  vtkNew<vtkMatrix4x4> nodeToWorld;
  toWorld(roi, nodeToWorld); // rejects transforms that a box cannot follow
  vtkNew<vtkMatrix4x4> matrix;
  matrix->DeepCopy(roi->GetObjectToWorldMatrix());
  double size[3];
  roi->GetSize(size);
  for (int axis = 0; axis < 3; ++axis) {
    if (!(size[axis] > 0))
      throw Error(ErrorCode::Geometry, "The region " + quoted(roi) + " is empty: place its corners first.");
    for (int row = 0; row < 3; ++row)
      matrix->SetElement(row, axis, matrix->GetElement(row, axis) * size[axis]);
  }
  const int one[3] = {1, 1, 1}, first[3] = {0, 0, 0};
  return vtk::gridOf(matrix, one, first, "The region " + quoted(roi));
}

int sliceAxis(vtkMatrix4x4* ijkToRAS) {
  Vec3 spacing;
  for (int a = 0; a < 3; ++a)
    spacing[a] =
        std::hypot(ijkToRAS->GetElement(0, a), ijkToRAS->GetElement(1, a), ijkToRAS->GetElement(2, a));
  return sliceAxisOf(spacing);
}

} // namespace innergs::mrml
