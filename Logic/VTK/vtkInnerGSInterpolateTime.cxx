#include "vtkInnerGSInterpolateTime.h"

#include "PipelineTime.h"
#include "vtkInnerGSModel.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

vtkStandardNewMacro(vtkInnerGSInterpolateTime);

vtkInnerGSInterpolateTime::vtkInnerGSInterpolateTime() = default;
vtkInnerGSInterpolateTime::~vtkInnerGSInterpolateTime() = default;

void vtkInnerGSInterpolateTime::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Time: " << this->Time << "\n";
  os << indent << "OutputTime: " << this->OutputTime << "\n";
}

int vtkInnerGSInterpolateTime::FillInputPortInformation(int, vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkInnerGSDynamicModel");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

int vtkInnerGSInterpolateTime::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkInnerGSModel");
  return 1;
}

void vtkInnerGSInterpolateTime::SetDynamicModel(vtkInnerGSDynamicModel* model) {
  this->SetInputData(model);
}

vtkInnerGSModel* vtkInnerGSInterpolateTime::GetOutput() {
  return vtkInnerGSModel::SafeDownCast(this->GetOutputDataObject(0));
}

void vtkInnerGSInterpolateTime::RequestInformation(vtkInformationVector** inputs,
                                                   vtkInformationVector* outputs) {
  innergs::vtk::announceTimes(outputs->GetInformationObject(0), vtkInnerGSDynamicModel::GetData(inputs[0]));
}

void vtkInnerGSInterpolateTime::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  vtkInnerGSDynamicModel* model = innergs::vtk::requireDynamicModel(inputs);
  vtkInformation* information = outputs->GetInformationObject(0);
  this->OutputTime = innergs::vtk::requestedTime(information, model, this->Time);
  vtkInnerGSModel* output = vtkInnerGSModel::GetData(outputs);
  const auto posed = vtkSmartPointer<vtkInnerGSModel>::Take(model->NewModelAt(this->OutputTime));
  output->ShallowCopy(posed);
  using Pipeline = vtkStreamingDemandDrivenPipeline;
  const double asked = information->Has(Pipeline::UPDATE_TIME_STEP())
                           ? information->Get(Pipeline::UPDATE_TIME_STEP())
                           : this->OutputTime;
  output->GetInformation()->Set(vtkDataObject::DATA_TIME_STEP(), asked);
}
