#include "vtkMRMLInnerGSModelNode.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Base/NumberText.h"
#include "HardenModel.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>

#include <vtkBoundingBox.h>
#include <vtkGeneralTransform.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <cmath>

vtkMRMLNodeNewMacro(vtkMRMLInnerGSModelNode);

namespace {

/// RAS matrices and LPS maps: x and y change sign on both sides.
constexpr double kFlip[3] = {-1, -1, 1};

innergs::Affine3 toLPS(vtkMatrix4x4* matrix) {
  innergs::Affine3 map;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      map.linear[i][j] = kFlip[i] * matrix->GetElement(i, j) * kFlip[j];
    map.offset[i] = kFlip[i] * matrix->GetElement(i, 3);
  }
  return map;
}

void toRAS(const innergs::Affine3& map, vtkMatrix4x4* matrix) {
  matrix->Identity();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      matrix->SetElement(i, j, kFlip[i] * map.linear[i][j] * kFlip[j]);
    matrix->SetElement(i, 3, kFlip[i] * map.offset[i]);
  }
}

bool sameMatrix(vtkMatrix4x4* a, vtkMatrix4x4* b) {
  return std::equal(a->GetData(), a->GetData() + 16, b->GetData());
}

} // namespace

vtkMRMLInnerGSModelNode::vtkMRMLInnerGSModelNode() = default;
vtkMRMLInnerGSModelNode::~vtkMRMLInnerGSModelNode() = default;

void vtkMRMLInnerGSModelNode::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Model: " << (this->IsEmpty() ? "(empty)" : this->Model->GetDescription()) << "\n";
}

void vtkMRMLInnerGSModelNode::WriteXML(ostream& of, int indent) {
  this->Superclass::WriteXML(of, indent);
  if (this->DynamicModel) of << " time=\"" << innergs::exactText(this->Time) << "\"";
}

void vtkMRMLInnerGSModelNode::ReadXMLAttributes(const char** attributes) {
  MRMLNodeModifyBlocker blocker(this);
  this->Superclass::ReadXMLAttributes(attributes);
  for (const char** a = attributes; a[0]; a += 2)
    if (std::string(a[0]) == "time") this->SetTime(innergs::wholeTextNumber(a[1]).value_or(0));
}

void vtkMRMLInnerGSModelNode::CopyContent(vtkMRMLNode* node, bool deepCopy) {
  MRMLNodeModifyBlocker blocker(this);
  this->Superclass::CopyContent(node, deepCopy);
  auto* other = vtkMRMLInnerGSModelNode::SafeDownCast(node);
  if (!other) return;
  this->Time = other->Time;
  if (other->DynamicModel) {
    vtkNew<vtkInnerGSDynamicModel> dynamic;
    dynamic->ShallowCopy(other->DynamicModel);
    this->SetDynamicModel(dynamic);
    return;
  }
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
  if (model == this->Model.Get() && !this->DynamicModel) return;
  this->DynamicModel = nullptr;
  this->Model = model;
  this->StorableModified();
  this->Modified();
  this->InvokeEvent(ModelModifiedEvent);
}

bool vtkMRMLInnerGSModelNode::IsEmpty() {
  return !this->Model || this->Model->IsEmpty();
}

void vtkMRMLInnerGSModelNode::SetFeatures(const std::shared_ptr<const innergs::FeatureModel>& features) {
  if (this->IsDynamic()) {
    vtkNew<vtkInnerGSDynamicModel> dynamic;
    dynamic->SetField(this->DynamicModel->GetField(), features);
    this->SetDynamicModel(dynamic);
  } else {
    vtkNew<vtkInnerGSModel> model;
    model->SetCoreModel(this->Model->GetCoreModel(), features);
    this->SetModel(model);
  }
}

vtkInnerGSDynamicModel* vtkMRMLInnerGSModelNode::GetDynamicModel() {
  return this->DynamicModel;
}

void vtkMRMLInnerGSModelNode::SetDynamicModel(vtkInnerGSDynamicModel* model) {
  if (model == this->DynamicModel.Get()) return;
  this->DynamicModel = model;
  this->StorableModified();
  this->ShowTime();
}

bool vtkMRMLInnerGSModelNode::IsDynamic() {
  return this->DynamicModel && !this->DynamicModel->IsEmpty();
}

double vtkMRMLInnerGSModelNode::GetTime() {
  return this->Time;
}

void vtkMRMLInnerGSModelNode::SetTime(double seconds) {
  if (!std::isfinite(seconds)) {
    vtkErrorMacro(<< "The time of a dynamic model must be finite: give it in seconds.");
    return;
  }
  double range[2];
  if (this->IsDynamic() && this->DynamicModel->GetTimeRange(range))
    seconds = std::clamp(seconds, range[0], range[1]);
  if (seconds == this->Time) return;
  this->Time = seconds;
  if (this->IsDynamic())
    this->ShowTime();
  else
    this->Modified(); // for the model that a storage node is about to read
}

void vtkMRMLInnerGSModelNode::ShowTime() {
  double range[2];
  if (this->IsDynamic() && this->DynamicModel->GetTimeRange(range))
    this->Time = std::clamp(this->Time, range[0], range[1]);
  this->Model = this->IsDynamic()
                    ? vtkSmartPointer<vtkInnerGSModel>::Take(this->DynamicModel->NewModelAt(this->Time))
                    : nullptr;
  this->Modified();
  this->InvokeEvent(ModelModifiedEvent);
}

bool vtkMRMLInnerGSModelNode::GetModifiedSinceRead() {
  vtkDataObject* kept =
      this->DynamicModel ? static_cast<vtkDataObject*>(this->DynamicModel.Get()) : this->Model;
  return this->Superclass::GetModifiedSinceRead() || (kept && kept->GetMTime() > this->GetStoredTime());
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
  const int steps = parent->IsTransformToWorldLinear() ? 1 : 8; // between corners: sides may bulge
  for (int n = 0; n < (steps + 1) * (steps + 1) * (steps + 1); ++n) {
    const int index[3] = {n % (steps + 1), n / (steps + 1) % (steps + 1), n / ((steps + 1) * (steps + 1))};
    double at[3], world[3];
    for (int a = 0; a < 3; ++a)
      at[a] = bounds[2 * a] + (bounds[2 * a + 1] - bounds[2 * a]) * index[a] / steps;
    toWorld->TransformPoint(at, world);
    box.AddPoint(world);
  }
  box.GetBounds(bounds);
}

bool vtkMRMLInnerGSModelNode::CanApplyNonLinearTransforms() const {
  return false;
}

void vtkMRMLInnerGSModelNode::ApplyTransformMatrix(vtkMatrix4x4* matrix) {
  this->Rest = nullptr;
  if (!matrix || this->IsEmpty()) return;
  // HardenTransform() calls this with the parent's matrix and then removes the parent, whatever the outcome.
  vtkNew<vtkMatrix4x4> parentToWorld;
  vtkMRMLTransformNode* parent = this->GetParentTransformNode();
  if (parent) parent->GetMatrixTransformToWorld(parentToWorld);
  const bool hardening = parent && this->Scene && sameMatrix(parentToWorld, matrix);
  try {
    if (this->DynamicModel)
      throw innergs::Error(
          innergs::ErrorCode::Geometry,
          "A model of a dynamic scan cannot be moved itself: put the transform on the node as "
          "a parent transform instead.");
    const auto hardened =
        innergs::mrml::harden(*this->Model->GetCoreModel(), this->Model->GetFeatures().get(), toLPS(matrix));
    if (!hardened.complete && !hardening)
      throw innergs::Error(innergs::ErrorCode::Geometry,
                           "The transform shears the model's grid: put it on the node as a parent transform "
                           "instead.");
    vtkNew<vtkInnerGSModel> model;
    model->SetCoreModel(hardened.model, hardened.features);
    this->SetModel(model);
    if (hardened.complete) return;
    this->Rest = vtkSmartPointer<vtkMatrix4x4>::New();
    toRAS(hardened.rest, this->Rest);
  } catch (...) {
    vtkErrorMacro(<< innergs::failureOf().sentence);
    if (!hardening) return;
    this->Rest = vtkSmartPointer<vtkMatrix4x4>::New();
    this->Rest->DeepCopy(matrix);
  }
}

void vtkMRMLInnerGSModelNode::OnNodeReferenceRemoved(vtkMRMLNodeReference* reference) {
  const vtkSmartPointer<vtkMatrix4x4> rest = this->Rest;
  const char* role = reference->GetReferenceRole();
  if (rest && role && std::string(role) == this->GetTransformNodeReferenceRole()) {
    this->Rest = nullptr;
    if (this->Scene && !this->Scene->IsClosing()) {
      const std::string name = std::string(this->GetName() ? this->GetName() : "Model") + " shear";
      auto* node = vtkMRMLTransformNode::SafeDownCast(this->Scene->AddNewNodeByClass(
          "vtkMRMLLinearTransformNode", this->Scene->GenerateUniqueName(name)));
      node->SetMatrixTransformToParent(rest);
      this->SetAndObserveTransformNodeID(node->GetID());
      return; // the removed one has been replaced, and observers notified of the new one
    }
  }
  this->Superclass::OnNodeReferenceRemoved(reference);
}
