#include "vtkSlicerInnerGSJob.h"

#include "Core/Base/NumberText.h"
#include "Core/Job/Progress.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkObjectFactory.h>

#include <cmath>
#include <limits>

vtkStandardNewMacro(vtkSlicerInnerGSJob);

vtkSlicerInnerGSJob::vtkSlicerInnerGSJob()
    : LastProgress(std::make_unique<innergs::Progress>()),
      UncertaintyCoverage(std::numeric_limits<double>::quiet_NaN()) {}
vtkSlicerInnerGSJob::~vtkSlicerInnerGSJob() = default;

void vtkSlicerInnerGSJob::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "State: " << GetStateAsString(this->State) << "\n";
  os << indent << "Description: " << this->GetDescription() << "\n";
  os << indent << "AgreementNote: " << this->AgreementNote << "\n";
  os << indent << "PredictionNote: " << this->PredictionNote << "\n";
  os << indent << "ProfileNote: " << this->ProfileNote << "\n";
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
  const innergs::Progress& last = *this->LastProgress;
  std::string line = innergs::formatted("%.60s, %.0f %%", this->GetPhase().c_str(), 100 * last.fraction);
  if (last.iteration > 0) line += innergs::formatted(", iteration %d of %d", last.iteration, last.iterations);
  if (std::isfinite(last.trainingPsnr))
    line += innergs::formatted(", %.1f dB on the fitted samples", last.trainingPsnr);
  if (last.remaining >= 1) line += innergs::formatted(", about %.0f s left", std::ceil(last.remaining));
  return line;
}

std::string vtkSlicerInnerGSJob::GetPhase() {
  return this->State == Queued ? "Waiting"
         : this->Learning      ? "Learning segments"
                               : innergs::phaseName(this->LastProgress->phase);
}
bool vtkSlicerInnerGSJob::IsJudging() {
  return this->State == Running && resultIsComplete(this->LastProgress->phase);
}
vtkIdType vtkSlicerInnerGSJob::GetNumberOfGaussians() {
  return static_cast<vtkIdType>(this->LastProgress->gaussians);
}
const innergs::Progress& vtkSlicerInnerGSJob::GetProgressReport() const {
  return *this->LastProgress;
}
int vtkSlicerInnerGSJob::GetNumberOfWarnings() {
  return static_cast<int>(this->Warnings.size());
}
std::string vtkSlicerInnerGSJob::GetWarning(int index) {
  return index >= 0 && index < this->GetNumberOfWarnings() ? this->Warnings[index] : "";
}

// Getters of how far it is.
#define INNERGS_PROGRESS(Type, Name, member)                                                                 \
  Type vtkSlicerInnerGSJob::Get##Name() {                                                                    \
    return this->LastProgress->member;                                                                       \
  }
INNERGS_PROGRESS(double, Progress, fraction)
INNERGS_PROGRESS(int, CurrentIteration, iteration)
INNERGS_PROGRESS(int, TotalIterations, iterations)
INNERGS_PROGRESS(double, Loss, loss)
INNERGS_PROGRESS(double, TrainingPSNR, trainingPsnr)
INNERGS_PROGRESS(double, HeldOutPSNR, heldOutPsnr)
INNERGS_PROGRESS(double, ElapsedSeconds, elapsed)
INNERGS_PROGRESS(double, RemainingSeconds, remaining)
#undef INNERGS_PROGRESS

// Getters of what it points to.
#define INNERGS_OBJECT(Type, Name, member)                                                                   \
  Type* vtkSlicerInnerGSJob::Get##Name() {                                                                   \
    return this->member;                                                                                     \
  }
INNERGS_OBJECT(vtkMRMLInnerGSParameterNode, ParameterNode, ParameterNode)
INNERGS_OBJECT(vtkImageData, PreviewImage, Preview)
INNERGS_OBJECT(vtkInnerGSDynamicModel, PreviewModel, PreviewModel)
INNERGS_OBJECT(vtkMatrix4x4, PreviewIJKToRASMatrix, PreviewIJKToRAS)
INNERGS_OBJECT(vtkMRMLScalarVolumeNode, VolumeNode, VolumeNode)
INNERGS_OBJECT(vtkMRMLInnerGSModelNode, ModelNode, ModelNode)
INNERGS_OBJECT(vtkMRMLScalarVolumeNode, UncertaintyNode, UncertaintyNode)
INNERGS_OBJECT(vtkMRMLLabelMapVolumeNode, MeasuredNode, MeasuredNode)
INNERGS_OBJECT(vtkMRMLTableNode, TableNode, TableNode)
INNERGS_OBJECT(vtkMRMLTableNode, SliceTableNode, SliceTableNode)
INNERGS_OBJECT(vtkMRMLSequenceNode, SequenceNode, SequenceNode)
INNERGS_OBJECT(vtkMRMLSequenceBrowserNode, BrowserNode, BrowserNode)
#undef INNERGS_OBJECT
