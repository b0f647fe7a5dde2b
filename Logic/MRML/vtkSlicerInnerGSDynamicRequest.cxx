#include "vtkSlicerInnerGSDynamicRequest.h"

#include "SettingsAccess.h"

#include <vtkMRMLSequenceNode.h>

#include <vtkDoubleArray.h>
#include <vtkObjectFactory.h>

vtkStandardNewMacro(vtkSlicerInnerGSDynamicRequest);

vtkSlicerInnerGSDynamicRequest::vtkSlicerInnerGSDynamicRequest()
    : Choices(std::make_unique<innergs::Settings>()) {}
vtkSlicerInnerGSDynamicRequest::~vtkSlicerInnerGSDynamicRequest() = default;

void vtkSlicerInnerGSDynamicRequest::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Series: " << (this->Series ? this->Series->GetName() : "(none)") << "\n";
  os << indent << "Interval: " << this->Interval << "\n";
  os << indent << "Settings: " << innergs::movingSettingsText(*this->Choices) << "\n";
  os << indent << "Rate: " << this->Rate << "\n";
  os << indent << "EvaluateQuality: " << this->EvaluateQuality << "\n";
  os << indent << "SliceTimingFileName: " << this->SliceTimingFileName << "\n";
  os << indent << "ResumeFileName: " << this->ResumeFileName << "\n";
  os << indent << "KeepWhenCancelled: " << this->KeepWhenCancelled << "\n";
}

vtkInnerGSSettingsAccessMacro(vtkSlicerInnerGSDynamicRequest);

const innergs::Settings& vtkSlicerInnerGSDynamicRequest::GetSettings() const {
  return *this->Choices;
}

void vtkSlicerInnerGSDynamicRequest::SetSettings(const innergs::Settings& settings) {
  if (settings == *this->Choices) return;
  *this->Choices = settings;
  this->Modified();
}

void vtkSlicerInnerGSDynamicRequest::SetSeries(vtkMRMLSequenceNode* sequence) {
  if (sequence == this->Series.Get()) return;
  this->Series = sequence;
  this->Modified();
}

vtkMRMLSequenceNode* vtkSlicerInnerGSDynamicRequest::GetSeries() {
  return this->Series;
}

void vtkSlicerInnerGSDynamicRequest::SetTimes(vtkDoubleArray* times) {
  if (times == this->Times.Get()) return;
  this->Times = times;
  this->Modified();
}

vtkDoubleArray* vtkSlicerInnerGSDynamicRequest::GetTimes() {
  return this->Times;
}

void vtkSlicerInnerGSDynamicRequest::SetSliceTimes(vtkDoubleArray* times) {
  if (times == this->SliceTimes.Get()) return;
  this->SliceTimes = times;
  this->Modified();
}

vtkDoubleArray* vtkSlicerInnerGSDynamicRequest::GetSliceTimes() {
  return this->SliceTimes;
}
