#include "vtkMRMLInnerGSModelNode.h"

#include "Core/ReconstructionJob.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>

#include <vtkBoundingBox.h>
#include <vtkGeneralTransform.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

vtkMRMLNodeNewMacro(vtkMRMLInnerGSModelNode);

namespace {

/// The LPS form of a RAS matrix; false when it does more than turn and shift.
bool rigidMap(vtkMatrix4x4* matrix, innergs::Affine3& map) {
  const double flip[3] = {-1, -1, 1};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      map.linear[i][j] = flip[i] * matrix->GetElement(i, j) * flip[j];
    map.offset[i] = flip[i] * matrix->GetElement(i, 3);
  }
  const innergs::Mat3 gram = innergs::transpose(map.linear) * map.linear;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] - (i == j)) <= 1e-4)) return false;
  return innergs::determinant(map.linear) > 0;
}

void move(innergs::GridGeometry& grid, const innergs::Affine3& map) {
  grid.origin = map(grid.origin);
  grid.direction = map.linear * grid.direction;
}

} // namespace

vtkMRMLInnerGSModelNode::vtkMRMLInnerGSModelNode() = default;
vtkMRMLInnerGSModelNode::~vtkMRMLInnerGSModelNode() = default;

void vtkMRMLInnerGSModelNode::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Model: " << (this->IsEmpty() ? "(empty)" : this->Model->GetDescription()) << "\n";
}

void vtkMRMLInnerGSModelNode::CopyContent(vtkMRMLNode* node, bool deepCopy) {
  MRMLNodeModifyBlocker blocker(this);
  this->Superclass::CopyContent(node, deepCopy);
  auto* other = vtkMRMLInnerGSModelNode::SafeDownCast(node);
  if (!other) return;
  vtkSmartPointer<vtkInnerGSModel> model;
  if (other->Model) {
    model = vtkSmartPointer<vtkInnerGSModel>::New();
    model->ShallowCopy(other->Model); // what it holds never changes
  }
  this->SetModel(model);
}

vtkMRMLStorageNode* vtkMRMLInnerGSModelNode::CreateDefaultStorageNode() {
  return vtkMRMLInnerGSModelStorageNode::New();
}

std::string vtkMRMLInnerGSModelNode::GetDefaultStorageNodeClassName(const char*) {
  return "vtkMRMLInnerGSModelStorageNode";
}

vtkInnerGSModel* vtkMRMLInnerGSModelNode::GetModel() {
  return this->Model;
}

void vtkMRMLInnerGSModelNode::SetModel(vtkInnerGSModel* model) {
  if (model == this->Model.Get()) return;
  this->Model = model;
  this->StorableModified();
  this->Modified();
  this->InvokeEvent(ModelModifiedEvent);
}

bool vtkMRMLInnerGSModelNode::IsEmpty() {
  return !this->Model || this->Model->IsEmpty();
}

bool vtkMRMLInnerGSModelNode::GetModifiedSinceRead() {
  return this->Superclass::GetModifiedSinceRead() ||
         (this->Model && this->Model->GetMTime() > this->GetStoredTime());
}

void vtkMRMLInnerGSModelNode::GetBounds(double bounds[6]) {
  if (this->IsEmpty())
    vtkBoundingBox().GetBounds(bounds);
  else
    this->Model->GetBounds(bounds);
}

void vtkMRMLInnerGSModelNode::GetRASBounds(double bounds[6]) {
  this->GetBounds(bounds);
  vtkMRMLTransformNode* parent = this->GetParentTransformNode();
  if (!parent || bounds[0] > bounds[1]) return;
  vtkNew<vtkGeneralTransform> toWorld;
  parent->GetTransformToWorld(toWorld);
  vtkBoundingBox box;
  for (int corner = 0; corner < 8; ++corner) {
    const double at[3] = {bounds[corner & 1], bounds[2 + (corner >> 1 & 1)], bounds[4 + (corner >> 2)]};
    double world[3];
    toWorld->TransformPoint(at, world);
    box.AddPoint(world);
  }
  box.GetBounds(bounds);
}

bool vtkMRMLInnerGSModelNode::CanApplyNonLinearTransforms() const {
  return false;
}

void vtkMRMLInnerGSModelNode::ApplyTransformMatrix(vtkMatrix4x4* matrix) {
  if (!matrix || this->IsEmpty()) return;
  innergs::Affine3 map;
  if (!rigidMap(matrix, map)) {
    vtkErrorMacro("The transform scales, shears or mirrors; a model is in millimetres and can only be turned "
                  "and shifted: transform the volume made from it instead.");
    return;
  }
  auto moved = std::make_shared<innergs::Checkpoint>(*this->Model->GetCheckpoint());
  moved->field.modelToWorld = map * moved->field.modelToWorld;
  move(moved->field.domain, map);
  move(moved->field.detail.geometry, map);
  vtkNew<vtkInnerGSModel> model;
  model->SetCheckpoint(std::move(moved));
  this->SetModel(model);
}
