#include "vtkInnerGSPointQuery.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"
#include "Core/Render/RenderPoints.h"
#include "Geometry.h"
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSModel.h"

#include "vtkFloatArray.h"
#include "vtkObjectFactory.h"
#include "vtkPoints.h"

#include <algorithm>
#include <limits>
#include <vector>

vtkStandardNewMacro(vtkInnerGSPointQuery);
vtkCxxSetObjectMacro(vtkInnerGSPointQuery, Model, vtkInnerGSModel);

vtkInnerGSPointQuery::vtkInnerGSPointQuery() = default;

vtkInnerGSPointQuery::~vtkInnerGSPointQuery() {
  this->SetModel(nullptr);
}

void vtkInnerGSPointQuery::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Model: " << this->Model << "\n";
  os << indent << "NumberOfThreads: " << this->NumberOfThreads << "\n";
  os << indent << "Device: " << this->Device << "\n";
  os << indent << "ErrorMessage: " << this->ErrorMessage << "\n";
}

vtkInnerGSModel* vtkInnerGSPointQuery::GetModel() {
  return this->Model;
}

std::string vtkInnerGSPointQuery::GetErrorMessage() {
  return this->ErrorMessage;
}

bool vtkInnerGSPointQuery::Evaluate(vtkPoints* points, vtkFloatArray* values) {
  using innergs::Error;
  using Code = innergs::ErrorCode;
  this->ErrorMessage.clear();
  this->ErrorCode = 0;
  if (values) values->Initialize();
  try {
    if (!points || !values)
      throw Error(Code::InvalidArgument, "A point query needs points and an array for their values.");
    const auto field = this->Model ? this->Model->GetField() : nullptr;
    if (!field)
      throw Error(Code::NoData, "There is no model, or it has no Gaussians: reconstruct or load one first.");
    const vtkIdType count = points->GetNumberOfPoints();
    std::vector<innergs::Vec3> positions(static_cast<std::size_t>(count));
    for (vtkIdType i = 0; i < count; ++i) {
      points->GetPoint(i, positions[i].data());
      positions[i] = innergs::vtk::flipped(positions[i]);
    }
    innergs::RenderOptions options;
    options.threads = this->NumberOfThreads;
    options.device = innergs::renderingDevice(this->Device, *field, count);
    const std::vector<float> result = renderPoints(*field, positions, options);
    values->SetName("Intensity");
    values->SetNumberOfComponents(1);
    values->SetNumberOfTuples(count);
    if (count > 0) std::copy(result.begin(), result.end(), values->GetPointer(0));
    return true;
  } catch (...) {
    const innergs::Failure failure = innergs::failureOf();
    this->ErrorMessage = failure.sentence;
    this->ErrorCode = vtkInnerGSAlgorithm::ToErrorNumber(failure.code);
  }
  vtkErrorMacro(<< this->ErrorMessage);
  return false;
}

double vtkInnerGSPointQuery::EvaluatePoint(double r, double a, double s) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->InsertNextPoint(r, a, s);
  vtkNew<vtkFloatArray> values;
  return this->Evaluate(points, values) ? static_cast<double>(values->GetValue(0))
                                        : std::numeric_limits<double>::quiet_NaN();
}
