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
  os << indent << "Settings: " << innergs::dynamicSettingsText(*this->Choices) << "\n";
  os << indent << "Rate: " << this->Rate << "\n";
  os << indent << "EvaluateQuality: " << this->EvaluateQuality << "\n";
  os << indent << "SliceTimingFileName: " << this->SliceTimingFileName << "\n";
  os << indent << "ResumeFileName: " << this->ResumeFileName << "\n";
  os << indent << "KeepWhenCancelled: " << this->KeepWhenCancelled << "\n";
}

vtkInnerGSOwnSettingsMacro(vtkSlicerInnerGSDynamicRequest);

// Setter and getter of an object.
#define INNERGS_OBJECT(Type, Name)                                                                           \
  vtkCxxSetSmartPointerMacro(vtkSlicerInnerGSDynamicRequest, Name, Type);                                    \
  Type* vtkSlicerInnerGSDynamicRequest::Get##Name() {                                                        \
    return this->Name;                                                                                       \
  }
INNERGS_OBJECT(vtkMRMLSequenceNode, Series)
INNERGS_OBJECT(vtkDoubleArray, Times)
INNERGS_OBJECT(vtkDoubleArray, SliceTimes)
#undef INNERGS_OBJECT
