#include "vtkSlicerInnerGSJob.h"

#include "Core/NumberText.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>

#include <cmath>
#include <limits>

vtkStandardNewMacro(vtkSlicerInnerGSJob);

vtkSlicerInnerGSJob::vtkSlicerInnerGSJob()
    : TrainingPSNR(std::numeric_limits<double>::quiet_NaN()),
      HeldOutPSNR(std::numeric_limits<double>::quiet_NaN()) {}
vtkSlicerInnerGSJob::~vtkSlicerInnerGSJob() = default;

void vtkSlicerInnerGSJob::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "State: " << GetStateAsString(this->State) << "\n";
  os << indent << "Description: " << this->GetDescription() << "\n";
  os << indent << "DeviceNote: " << this->DeviceNote << "\n";
  os << indent << "UsedSettings: " << this->UsedSettings << "\n";
  for (const std::string& warning : this->Warnings)
    os << indent << "Warning: " << warning << "\n";
}

const char* vtkSlicerInnerGSJob::GetStateAsString(int state) {
  const char* const names[] = {"Queued", "Running", "Finished", "Failed", "Cancelled"};
  return state >= Queued && state <= Cancelled ? names[state] : "";
}

bool vtkSlicerInnerGSJob::IsDone() {
  return this->State >= Finished;
}

std::string vtkSlicerInnerGSJob::GetDescription() {
  if (this->State == Failed) return this->ErrorMessage;
  if (this->State != Running) return GetStateAsString(this->State);
  std::string line = innergs::formatted("%.60s, %.0f %%", this->Phase.c_str(), 100 * this->Progress);
  if (this->CurrentIteration > 0)
    line += innergs::formatted(", sweep %d of %d, %.1f dB", this->CurrentIteration, this->TotalIterations,
                               this->TrainingPSNR);
  if (this->RemainingSeconds >= 1)
    line += innergs::formatted(", about %.0f s left", std::ceil(this->RemainingSeconds));
  return line;
}

vtkMRMLInnerGSParameterNode* vtkSlicerInnerGSJob::GetParameterNode() {
  return this->ParameterNode;
}
vtkImageData* vtkSlicerInnerGSJob::GetPreviewImage() {
  return this->Preview;
}
vtkMatrix4x4* vtkSlicerInnerGSJob::GetPreviewIJKToRASMatrix() {
  return this->PreviewIJKToRAS;
}
int vtkSlicerInnerGSJob::GetNumberOfWarnings() {
  return static_cast<int>(this->Warnings.size());
}
std::string vtkSlicerInnerGSJob::GetWarning(int index) {
  return index >= 0 && index < this->GetNumberOfWarnings() ? this->Warnings[index] : "";
}
vtkMRMLScalarVolumeNode* vtkSlicerInnerGSJob::GetVolumeNode() {
  return this->VolumeNode;
}
vtkMRMLInnerGSModelNode* vtkSlicerInnerGSJob::GetModelNode() {
  return this->ModelNode;
}
vtkMRMLTableNode* vtkSlicerInnerGSJob::GetTableNode() {
  return this->TableNode;
}
