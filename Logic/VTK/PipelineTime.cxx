#include "PipelineTime.h"

#include "Core/Base/Error.h"
#include "Core/Motion/DynamicField.h"

#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <cmath>

namespace innergs::vtk {

using Pipeline = vtkStreamingDemandDrivenPipeline;

void announceTimes(vtkInformation* output, vtkInnerGSDynamicModel* model) {
  if (!model || model->IsEmpty()) return;
  const std::vector<double>& times = model->GetField()->times;
  const double range[2] = {times.front(), times.back()};
  output->Set(Pipeline::TIME_STEPS(), times.data(), static_cast<int>(times.size()));
  output->Set(Pipeline::TIME_RANGE(), range, 2);
}

double requestedTime(vtkInformation* output, vtkInnerGSDynamicModel* model, double otherwise) {
  const double time =
      output->Has(Pipeline::UPDATE_TIME_STEP()) ? output->Get(Pipeline::UPDATE_TIME_STEP()) : otherwise;
  if (!std::isfinite(time)) throw Error(ErrorCode::InvalidArgument, "The time must be finite.");
  double range[2] = {time, time};
  model->GetTimeRange(range);
  return std::clamp(time, range[0], range[1]);
}

vtkInnerGSDynamicModel* requireDynamicModel(vtkInformationVector** inputs) {
  vtkInnerGSDynamicModel* model = vtkInnerGSDynamicModel::GetData(inputs[0]);
  if (!model || model->IsEmpty())
    throw Error(
        ErrorCode::NoData,
        "There is no model of a dynamic scan, or it has no Gaussians: reconstruct or load one first.");
  return model;
}

} // namespace innergs::vtk
