#include "vtkInnerGSMotionField.h"

#include "Core/Motion/MotionField.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "PipelineTime.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

vtkStandardNewMacro(vtkInnerGSMotionField);

struct vtkInnerGSMotionField::Internals {
  innergs::vtk::ReferenceGrid reference;
  vtkNew<vtkMatrix4x4> outputToRAS;

  innergs::GridGeometry grid(const innergs::DynamicField& field) const {
    return reference.given() ? reference.grid() : field.canonical.region();
  }
};

vtkInnerGSMotionField::vtkInnerGSMotionField() : Work(std::make_unique<Internals>()) {}
vtkInnerGSMotionField::~vtkInnerGSMotionField() = default;

void vtkInnerGSMotionField::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Time: " << this->Time << "\n";
  os << indent << "From: " << this->From << "\n";
  os << indent << "UseMiddleFrame: " << this->UseMiddleFrame << "\n";
}

int vtkInnerGSMotionField::FillInputPortInformation(int, vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkInnerGSDynamicModel");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

void vtkInnerGSMotionField::SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ,
                                             int dimensionK) {
  const int dimensions[3] = {dimensionI, dimensionJ, dimensionK}, first[3] = {0, 0, 0};
  if (this->Work->reference.set(ijkToRAS, dimensions, first)) this->Modified();
}

void vtkInnerGSMotionField::SetDynamicModel(vtkInnerGSDynamicModel* model) {
  this->SetInputData(model);
}

vtkImageData* vtkInnerGSMotionField::GetOutput() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(0));
}

vtkMatrix4x4* vtkInnerGSMotionField::GetOutputIJKToRASMatrix() {
  return this->Work->outputToRAS;
}

void vtkInnerGSMotionField::RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  vtkInnerGSDynamicModel* model = innergs::vtk::requireDynamicModel(inputs);
  vtkInformation* output = outputs->GetInformationObject(0);
  innergs::vtk::announceTimes(output, model);
  innergs::vtk::announceImage(output, this->Work->grid(*model->GetField()), this->GeometryInImage);
  vtkDataObject::SetPointDataActiveScalarInfo(output, VTK_FLOAT, 3);
}

void vtkInnerGSMotionField::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  vtkInnerGSDynamicModel* model = innergs::vtk::requireDynamicModel(inputs);
  const auto field = model->GetField();
  const innergs::GridGeometry grid = this->Work->grid(*field);
  vtkInformation* information = outputs->GetInformationObject(0);
  const double time = innergs::vtk::requestedTime(information, model, this->Time);
  const double from = this->UseMiddleFrame ? innergs::middleTime(*field) : this->From;
  const std::vector<float> lps =
      innergs::motionField(*field, from, time, grid, this->NumberOfThreads, this->GetStopToken());
  vtkImageData* image = vtkImageData::GetData(outputs);
  float* out = innergs::vtk::allocateFloats(image, grid, this->GeometryInImage, 3);
  image->GetPointData()->GetScalars()->SetName("Displacement");
  for (std::size_t n = 0; n < lps.size(); n += 3) {
    out[n] = -lps[n];
    out[n + 1] = -lps[n + 1];
    out[n + 2] = lps[n + 2];
  }
  innergs::vtk::toMatrix(grid, this->Work->outputToRAS);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  image->GetInformation()->Set(
      vtkDataObject::DATA_TIME_STEP(),
      information->Has(Pipeline::UPDATE_TIME_STEP()) ? information->Get(Pipeline::UPDATE_TIME_STEP()) : time);
}
