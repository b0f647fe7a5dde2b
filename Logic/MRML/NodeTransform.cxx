#include "NodeTransform.h"

#include "NodeGeometry.h"

#include <vtkMRMLTransformNode.h>

#include <vtkCallbackCommand.h>
#include <vtkCollection.h>
#include <vtkGeneralTransform.h>
#include <vtkGridTransform.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkTransform.h>

namespace innergs::mrml {
namespace {

/// Shares no object with the original, except possibly the voxels of a displacement field, which are many.
vtkSmartPointer<vtkAbstractTransform> copyOf(vtkAbstractTransform* part) {
  part->Update();
  auto copy = vtkSmartPointer<vtkAbstractTransform>::Take(part->MakeTransform());
  auto* grid = vtkGridTransform::SafeDownCast(copy);
  if (grid) {
    copy->DeepCopy(part);
    if (vtkImageData* field = grid->GetDisplacementGrid()) {
      vtkNew<vtkImageData> own;
      own->ShallowCopy(field);
      grid->SetDisplacementGridData(own);
    }
  } else {
    vtkMRMLTransformNode::DeepCopyTransform(copy, part);
  }
  // An inexact inverse somewhere must not flood the console.
  vtkNew<vtkCallbackCommand> quiet;
  copy->AddObserver(vtkCommand::WarningEvent, quiet);
  return copy;
}

} // namespace

vtkSmartPointer<vtkAbstractTransform> transformFromWorld(vtkMRMLTransformableNode* node) {
  vtkMRMLTransformNode* parent = node->GetParentTransformNode();
  if (!parent) return nullptr;
  if (parent->IsTransformToWorldLinear()) {
    vtkNew<vtkMatrix4x4> matrix;
    toWorld(node, matrix);
    if (matrix->IsIdentity()) return nullptr;
    matrix->Invert();
    auto linear = vtkSmartPointer<vtkTransform>::New();
    linear->SetMatrix(matrix);
    return linear;
  }
  vtkNew<vtkGeneralTransform> shared;
  parent->GetTransformFromWorld(shared);
  vtkNew<vtkCollection> parts;
  vtkMRMLTransformNode::FlattenGeneralTransform(parts, shared);
  auto own = vtkSmartPointer<vtkGeneralTransform>::New();
  own->PostMultiply(); // the first part is applied first
  for (int i = 0; i < parts->GetNumberOfItems(); ++i)
    own->Concatenate(copyOf(vtkAbstractTransform::SafeDownCast(parts->GetItemAsObject(i))));
  own->Update();
  return own;
}

} // namespace innergs::mrml
