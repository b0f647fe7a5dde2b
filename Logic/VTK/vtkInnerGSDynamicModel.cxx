#include "vtkInnerGSDynamicModel.h"

#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Features/FeatureModel.h"
#include "Core/Model/Model.h"
#include "Core/Motion/DynamicField.h"
#include "vtkInnerGSModel.h"

#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"

#include <cmath>
#include <limits>

vtkStandardNewMacro(vtkInnerGSDynamicModel);

vtkInnerGSDynamicModel::vtkInnerGSDynamicModel() = default;
vtkInnerGSDynamicModel::~vtkInnerGSDynamicModel() = default;

void vtkInnerGSDynamicModel::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Description: " << this->GetDescription() << "\n";
}

void vtkInnerGSDynamicModel::Initialize() {
  this->Superclass::Initialize();
  this->Field.reset();
  this->Features.reset();
}

void vtkInnerGSDynamicModel::ShallowCopy(vtkDataObject* source) {
  this->Superclass::ShallowCopy(source);
  this->Share(vtkInnerGSDynamicModel::SafeDownCast(source));
}

void vtkInnerGSDynamicModel::DeepCopy(vtkDataObject* source) {
  this->Superclass::DeepCopy(source);
  this->Share(vtkInnerGSDynamicModel::SafeDownCast(source));
}

void vtkInnerGSDynamicModel::Share(vtkInnerGSDynamicModel* model) {
  if (!model) return;
  this->Field = model->Field;
  this->Features = model->Features;
}

unsigned long vtkInnerGSDynamicModel::GetActualMemorySize() {
  unsigned long size = this->Superclass::GetActualMemorySize();
  if (this->Field) {
    const innergs::DynamicField& f = *this->Field;
    const std::size_t bytes = f.canonical.gaussians.size() * sizeof(innergs::Gaussian) +
                              (f.canonical.residual.voxels.size() + f.nodes.size() + f.anchors.size() +
                               f.ownPath.size() + f.changes.size()) *
                                  sizeof(float) +
                              (this->Features ? innergs::memoryOf(*this->Features) : 0);
    size += static_cast<unsigned long>((bytes + 1023) / 1024);
  }
  return size;
}

void vtkInnerGSDynamicModel::SetField(std::shared_ptr<const innergs::DynamicField> field,
                                      std::shared_ptr<const innergs::FeatureModel> features) {
  if (field == this->Field && features == this->Features) return;
  this->Field = std::move(field);
  this->Features = std::move(features);
  this->Modified();
}

bool vtkInnerGSDynamicModel::IsEmpty() {
  return this->GetNumberOfGaussians() == 0;
}

vtkIdType vtkInnerGSDynamicModel::GetNumberOfGaussians() {
  return this->Field ? static_cast<vtkIdType>(this->Field->size()) : 0;
}

std::string vtkInnerGSDynamicModel::GetKindName() {
  return this->IsEmpty() ? "" : innergs::dynamicKindName(this->Field->kind);
}

std::string vtkInnerGSDynamicModel::GetDescription() {
  if (this->IsEmpty()) return "Empty model of a dynamic scan";
  double range[2];
  this->GetTimeRange(range);
  return innergs::countText(this->GetNumberOfGaussians()) + " Gaussians in time (" + this->GetKindName() +
         "), " + innergs::countText(this->GetNumberOfFrames()) + " frames from " +
         innergs::numberText(range[0]) + " s to " + innergs::numberText(range[1]) + " s, " +
         innergs::bytesText(1024.0 * static_cast<double>(this->GetActualMemorySize()));
}

int vtkInnerGSDynamicModel::GetNumberOfFrames() {
  return this->Field ? static_cast<int>(this->Field->times.size()) : 0;
}

double vtkInnerGSDynamicModel::GetFrameTime(int index) {
  return index >= 0 && index < this->GetNumberOfFrames() ? this->Field->times[index]
                                                         : std::numeric_limits<double>::quiet_NaN();
}

bool vtkInnerGSDynamicModel::GetTimeRange(double range[2]) {
  if (this->IsEmpty()) return false;
  range[0] = this->Field->times.front();
  range[1] = this->Field->times.back();
  return true;
}

int vtkInnerGSDynamicModel::GetNumberOfSegments() {
  return this->Features ? this->Features->classes() - 1 : 0; // without the background
}

std::string vtkInnerGSDynamicModel::GetSegmentName(int index) {
  return index >= 0 && index < this->GetNumberOfSegments()
             ? this->Features->names[static_cast<std::size_t>(index) + 1]
             : "";
}

vtkInnerGSModel* vtkInnerGSDynamicModel::NewModelAt(double time) {
  if (this->IsEmpty() || !std::isfinite(time)) return nullptr;
  auto core = std::make_shared<innergs::Model>();
  core->field = innergs::fieldAt(*this->Field, time);
  core->finished = core->field.size();
  vtkInnerGSModel* model = vtkInnerGSModel::New();
  model->SetCoreModel(std::move(core), this->Features, this->Field, time);
  return model;
}

vtkInnerGSDynamicModel* vtkInnerGSDynamicModel::GetData(vtkInformation* information) {
  return vtkInnerGSDynamicModel::SafeDownCast(vtkDataObject::GetData(information));
}

vtkInnerGSDynamicModel* vtkInnerGSDynamicModel::GetData(vtkInformationVector* informations, int index) {
  return informations ? vtkInnerGSDynamicModel::GetData(informations->GetInformationObject(index)) : nullptr;
}
