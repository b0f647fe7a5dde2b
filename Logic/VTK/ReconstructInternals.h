#pragma once
#include "Core/Job/ReconstructionJob.h"
#include "ReconstructInputs.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSReconstruct.h"

#include "vtkImageData.h"
#include "vtkNew.h"

/// What vtkInnerGSReconstruct keeps beside its plain settings.
struct vtkInnerGSReconstruct::Internals {
  innergs::vtk::ReconstructInputs inputs;
  innergs::vtk::ReferenceGrid reference;
  vtkSmartPointer<vtkMatrix4x4> regionToRAS;
  vtkSmartPointer<vtkInnerGSModel> resume;
  std::optional<innergs::ReconstructionInput> snapshot;
  vtkNew<vtkMatrix4x4> outputToRAS, previewToRAS;
  vtkNew<vtkImageData> preview;
  innergs::Phase phase = innergs::Phase::Preparing;
  std::vector<std::string> warnings;
  std::string usedSettings, usedInstructionSet, usedDevice, deviceNote;
};
