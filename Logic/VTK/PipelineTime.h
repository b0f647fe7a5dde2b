#pragma once
#include "vtkInnerGSDynamicModel.h"

class vtkInformation;

namespace innergs::vtk {

/// Announces the frames' times of a dynamic scan's model in a pipeline's output information; nothing when the
/// model is empty or null.
void announceTimes(vtkInformation* output, vtkInnerGSDynamicModel* model);

/// The time (s) that the pipeline asks for, else `otherwise`; clamped to the model's range. Throws
/// Error(InvalidArgument) when it is not finite.
double requestedTime(vtkInformation* output, vtkInnerGSDynamicModel* model, double otherwise);

/// The model on the first input port; throws Error(NoData) when there is none or it is empty.
vtkInnerGSDynamicModel* requireDynamicModel(vtkInformationVector** inputs);

} // namespace innergs::vtk
