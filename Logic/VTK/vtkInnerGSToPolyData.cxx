#include "vtkInnerGSToPolyData.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Core/Model/FieldValue.h"
#include "Core/Model/GaussianMath.h"
#include "Core/Render/Disagreement.h"
#include "Geometry.h"
#include "vtkInnerGSModel.h"

#include "vtkCellArray.h"
#include "vtkFloatArray.h"
#include "vtkInformation.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkPoints.h"
#include "vtkPolyData.h"

#include <algorithm>
#include <cmath>
#include <vector>

vtkStandardNewMacro(vtkInnerGSToPolyData);

namespace {

using innergs::Gaussian;
using innergs::Mat3;
using innergs::Vec3;

vtkFloatArray* addArray(vtkPolyData* data, const char* name, int components, vtkIdType count) {
  vtkNew<vtkFloatArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(count);
  data->GetPointData()->AddArray(array);
  return vtkFloatArray::SafeDownCast(data->GetPointData()->GetArray(name));
}

/// The quaternion (w, x, y, z; w ≥ 0) of a rotation matrix.
void toQuaternion(const Mat3& r, float out[4]) {
  double q[4];
  const double trace = r[0][0] + r[1][1] + r[2][2];
  int largest = 0; // the component that is certainly not small
  for (int a = 1; a < 4; ++a)
    if (const double d = r[a - 1][a - 1]; d > (largest ? r[largest - 1][largest - 1] : trace)) largest = a;
  if (largest == 0) {
    q[0] = 1 + trace;
    for (int a = 0; a < 3; ++a)
      q[a + 1] = r[(a + 2) % 3][(a + 1) % 3] - r[(a + 1) % 3][(a + 2) % 3];
  } else {
    const int i = largest - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q[0] = r[k][j] - r[j][k];
    q[i + 1] = 1 + r[i][i] - r[j][j] - r[k][k];
    q[j + 1] = r[i][j] + r[j][i];
    q[k + 1] = r[i][k] + r[k][i];
  }
  double length = 0;
  for (const double x : q)
    length += x * x;
  length = std::copysign(std::sqrt(length), q[0]);
  for (int a = 0; a < 4; ++a)
    out[a] = static_cast<float>(q[a] / length);
}

/// The Gaussians whose centre has a value, as far as the mask decides.
std::vector<std::size_t> centredInside(const innergs::GaussianField& field) {
  const innergs::FieldValue value(field, field.modelToWorld, {});
  std::vector<std::size_t> inside;
  inside.reserve(field.gaussians.size());
  for (std::size_t i = 0; i < field.gaussians.size(); ++i) {
    const Gaussian& g = field.gaussians[i];
    if (value.supported({g.mean[0], g.mean[1], g.mean[2]})) inside.push_back(i);
  }
  return inside;
}

} // namespace

vtkInnerGSToPolyData::vtkInnerGSToPolyData() = default;
vtkInnerGSToPolyData::~vtkInnerGSToPolyData() = default;

void vtkInnerGSToPolyData::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "MaximumNumberOfGaussians: " << this->MaximumNumberOfGaussians << "\n";
  os << indent << "EllipsoidRadius: " << this->EllipsoidRadius << "\n";
  os << indent << "ComputeDisagreement: " << this->ComputeDisagreement << "\n";
}

int vtkInnerGSToPolyData::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkPolyData");
  return 1;
}

vtkPolyData* vtkInnerGSToPolyData::GetOutput() {
  return vtkPolyData::SafeDownCast(this->GetOutputDataObject(0));
}

void vtkInnerGSToPolyData::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  const auto field = this->RequireModel(inputs)->GetField();
  innergs::checkField(*field);
  if (!std::isfinite(this->EllipsoidRadius) || this->EllipsoidRadius <= 0)
    throw innergs::Error(innergs::ErrorCode::InvalidArgument,
                         "The radius of the ellipsoids must be finite and above zero.");
  const std::vector<std::size_t> shown = centredInside(*field);
  const vtkIdType all = static_cast<vtkIdType>(shown.size());
  const vtkIdType count =
      this->MaximumNumberOfGaussians > 0 ? std::min(all, this->MaximumNumberOfGaussians) : all;
  const bool alpha = field->blending == innergs::Blending::Alpha;
  std::vector<float> disagreement;
  if (this->ComputeDisagreement && field->blending == innergs::Blending::Normalised) {
    this->SetProgressText("Comparing neighbours");
    disagreement = innergs::disagreement(*field, this->NumberOfThreads, this->GetStopToken());
  }
  this->SetProgressText("Exporting Gaussians");

  vtkNew<vtkPolyData> data;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToFloat();
  points->SetNumberOfPoints(count);
  vtkFloatArray* intensity = addArray(data, "Intensity", 1, count);
  vtkFloatArray* ellipsoid = addArray(data, "Ellipsoid", 9, count);
  vtkFloatArray* scales = addArray(data, "Scales", 3, count);
  vtkFloatArray* orientation = addArray(data, "Orientation", 4, count);
  vtkFloatArray* weight = addArray(data, "Weight", 1, count);
  vtkFloatArray* differing = disagreement.empty() ? nullptr : addArray(data, "Disagreement", 1, count);

  const innergs::Affine3 toRAS = innergs::vtk::flipped(field->modelToWorld);
  const auto stop = this->GetStopToken();
  for (vtkIdType out = 0; out < count; ++out) {
    if (out % 65536 == 0) {
      this->UpdateProgress(static_cast<double>(out) / static_cast<double>(count));
      innergs::throwIfStopped(stop);
    }
    const std::size_t i = shown[static_cast<std::size_t>(static_cast<double>(out) * static_cast<double>(all) /
                                                         static_cast<double>(count))];
    const Gaussian& g = field->gaussians[i];
    const Vec3 centre = toRAS({g.mean[0], g.mean[1], g.mean[2]});
    points->SetPoint(out, centre.data());
    float local[9];
    innergs::math::rotation(g.quaternion, local);
    Mat3 axes;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        axes[r][c] = local[3 * r + c];
    axes = toRAS.linear * axes; // the flip is half a turn about z, so this is still a rotation
    Mat3 scaled = axes;
    for (int c = 0; c < 3; ++c) {
      const double scale = std::exp(static_cast<double>(g.logScale[c]));
      scales->SetTypedComponent(out, c, static_cast<float>(scale));
      for (int r = 0; r < 3; ++r)
        scaled[r][c] *= scale * this->EllipsoidRadius;
    }
    const Mat3 tensor = scaled * transpose(axes);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        ellipsoid->SetTypedComponent(out, 3 * r + c, static_cast<float>(0.5 * (tensor[r][c] + tensor[c][r])));
    float quaternion[4];
    toQuaternion(axes, quaternion);
    orientation->SetTypedTuple(out, quaternion);
    intensity->SetValue(out,
                        static_cast<float>(field->intensityScale * g.intensity + field->intensityOffset));
    weight->SetValue(out, alpha ? 1 / (1 + std::exp(-g.logWeight)) : std::exp(g.logWeight));
    if (differing) differing->SetValue(out, disagreement[i]);
  }
  data->SetPoints(points);
  vtkNew<vtkCellArray> vertices;
  vertices->AllocateExact(count, count);
  for (vtkIdType i = 0; i < count; ++i)
    vertices->InsertNextCell(1, &i);
  data->SetVerts(vertices);
  data->GetPointData()->SetActiveScalars("Intensity");
  data->GetPointData()->SetActiveTensors("Ellipsoid");
  vtkPolyData::GetData(outputs)->ShallowCopy(data);
  this->UpdateProgress(1);
}
