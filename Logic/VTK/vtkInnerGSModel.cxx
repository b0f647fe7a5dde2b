#include "vtkInnerGSModel.h"

#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"
#include "Core/Features/FeatureModel.h"
#include "Core/Image/Bounds.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Model/FieldValue.h"
#include "Geometry.h"
#include "Text/SegmentedModel.h"

#include "vtkInformationVector.h"
#include "vtkMath.h"
#include "vtkMatrix4x4.h"
#include "vtkObjectFactory.h"

vtkStandardNewMacro(vtkInnerGSModel);

vtkInnerGSModel::vtkInnerGSModel() = default;
vtkInnerGSModel::~vtkInnerGSModel() = default;

void vtkInnerGSModel::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Description: " << this->GetDescription() << "\n";
}

void vtkInnerGSModel::Initialize() {
  this->Superclass::Initialize();
  this->CoreModel.reset();
  this->Features.reset();
  this->Dynamic.reset();
}

void vtkInnerGSModel::ShallowCopy(vtkDataObject* source) {
  this->Superclass::ShallowCopy(source);
  this->Share(vtkInnerGSModel::SafeDownCast(source));
}

void vtkInnerGSModel::DeepCopy(vtkDataObject* source) {
  this->Superclass::DeepCopy(source);
  this->Share(vtkInnerGSModel::SafeDownCast(source));
}

void vtkInnerGSModel::Share(vtkInnerGSModel* model) {
  if (!model) return;
  this->CoreModel = model->CoreModel;
  this->Features = model->Features;
  this->Dynamic = model->Dynamic;
  this->Time = model->Time;
}

unsigned long vtkInnerGSModel::GetActualMemorySize() {
  unsigned long size = this->Superclass::GetActualMemorySize();
  if (this->CoreModel) {
    const auto& c = *this->CoreModel;
    const std::size_t bytes =
        c.field.gaussians.size() * sizeof(innergs::Gaussian) +
        (c.optimizer.moment1.size() + c.optimizer.moment2.size() + c.field.residual.voxels.size()) *
            sizeof(float) +
        c.field.support.voxels.size() + (this->Features ? innergs::memoryOf(*this->Features) : 0);
    size += static_cast<unsigned long>((bytes + 1023) / 1024);
  }
  return size;
}

void vtkInnerGSModel::SetCoreModel(std::shared_ptr<const innergs::Model> core,
                                   std::shared_ptr<const innergs::FeatureModel> features,
                                   std::shared_ptr<const innergs::DynamicField> dynamic, double time) {
  if (core == this->CoreModel && features == this->Features && dynamic == this->Dynamic && time == this->Time)
    return;
  this->CoreModel = std::move(core);
  this->Features = std::move(features);
  this->Dynamic = std::move(dynamic);
  this->Time = time;
  this->Modified();
}

innergs::SegmentedModel vtkInnerGSModel::GetSegmented() const {
  return {this->GetField(), this->Features, this->Dynamic, this->Time};
}

std::shared_ptr<const innergs::GaussianField> vtkInnerGSModel::GetField() const {
  if (!this->CoreModel || this->CoreModel->field.gaussians.empty()) return nullptr;
  return {this->CoreModel, &this->CoreModel->field};
}

bool vtkInnerGSModel::IsEmpty() {
  return this->GetNumberOfGaussians() == 0;
}

vtkIdType vtkInnerGSModel::GetNumberOfGaussians() {
  return this->CoreModel ? static_cast<vtkIdType>(this->CoreModel->field.size()) : 0;
}

int vtkInnerGSModel::GetNumberOfIterations() {
  return this->CoreModel ? this->CoreModel->iteration : 0;
}

std::string vtkInnerGSModel::GetBlendingName() {
  return this->IsEmpty() ? "" : innergs::blendingName(this->CoreModel->field.blending);
}

std::string vtkInnerGSModel::GetDescription() {
  if (this->IsEmpty()) return "Empty model";
  const auto& field = this->CoreModel->field;
  std::string text = innergs::countText(this->GetNumberOfGaussians()) + " Gaussians, " +
                     this->GetBlendingName() + " blending";
  if (field.region().voxelCount() > 0) {
    double b[6];
    this->GetBounds(b);
    text +=
        innergs::formatted(", %.1f x %.1f x %.1f mm along R, A, S", b[1] - b[0], b[3] - b[2], b[5] - b[4]);
  }
  if (!field.residual.voxels.empty()) text += ", with a residual grid";
  if (this->IsMasked()) text += ", inside a mask";
  if (const int segments = this->GetNumberOfSegments(); segments > 0)
    text += ", " + innergs::countText(segments) + (segments == 1 ? " named segment" : " named segments");
  return text + ", " + innergs::bytesText(1024.0 * static_cast<double>(this->GetActualMemorySize()));
}

void vtkInnerGSModel::GetBounds(double bounds[6]) {
  vtkMath::UninitializeBounds(bounds);
  const auto field = this->GetField();
  if (!field) return;
  innergs::Bounds box;
  if (field->region().voxelCount() > 0) {
    for (const innergs::Vec3& corner : field->region().corners())
      box.include(innergs::vtk::flipped(corner));
  } else {
    for (const innergs::Gaussian& g : field->gaussians)
      box.include(innergs::vtk::flipped(field->modelToWorld({g.mean[0], g.mean[1], g.mean[2]})));
  }
  for (int a = 0; a < 3; ++a) {
    bounds[2 * a] = box.low[a];
    bounds[2 * a + 1] = box.high[a];
  }
}

bool vtkInnerGSModel::GetDomain(vtkMatrix4x4* ijkToRAS, int dimensions[3]) {
  const auto field = this->GetField();
  if (!field || field->region().voxelCount() == 0) return false;
  if (ijkToRAS) innergs::vtk::toMatrix(field->region(), ijkToRAS);
  for (int a = 0; a < 3; ++a)
    dimensions[a] = static_cast<int>(field->region().size[a]);
  return true;
}

bool vtkInnerGSModel::IsMasked() {
  return this->CoreModel && !this->CoreModel->field.support.voxels.empty();
}

bool vtkInnerGSModel::IsInside(double r, double a, double s) {
  const auto field = this->GetField();
  return field && innergs::FieldValue(*field, {}, {}).has(innergs::vtk::flipped(innergs::Vec3{r, a, s}));
}

double vtkInnerGSModel::GetFillValue() {
  return this->IsMasked() ? this->CoreModel->field.fill : this->GetBackgroundValue();
}

bool vtkInnerGSModel::GetValueRange(double range[2]) {
  if (this->IsEmpty() || !this->CoreModel->field.range) return false;
  range[0] = this->CoreModel->field.range->low;
  range[1] = this->CoreModel->field.range->high;
  return true;
}

double vtkInnerGSModel::GetBackgroundValue() {
  return this->IsEmpty() ? 0 : this->CoreModel->field.intensityOffset;
}

int vtkInnerGSModel::GetNumberOfSegments() {
  return this->Features ? this->Features->classes() - 1 : 0; // without the background
}

std::string vtkInnerGSModel::GetSegmentName(int index) {
  return index >= 0 && index < this->GetNumberOfSegments()
             ? this->Features->names[static_cast<std::size_t>(index) + 1]
             : "";
}

vtkInnerGSModel* vtkInnerGSModel::GetData(vtkInformation* information) {
  return vtkInnerGSModel::SafeDownCast(vtkDataObject::GetData(information));
}

vtkInnerGSModel* vtkInnerGSModel::GetData(vtkInformationVector* informations, int index) {
  return informations ? vtkInnerGSModel::GetData(informations->GetInformationObject(index)) : nullptr;
}
