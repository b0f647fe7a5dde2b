#include "vtkInnerGSPlaneQuery.h"

#include "Core/Base/Error.h"
#include "Core/Device/Devices.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/RenderPoints.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "ReconstructInputs.h"
#include "UncertaintyImage.h"
#include "vtkInnerGSModel.h"

#include "vtkAbstractTransform.h"
#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkLinearTransform.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkPointData.h"
#include "vtkSmartPointer.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <vector>

vtkStandardNewMacro(vtkInnerGSPlaneQuery);

struct vtkInnerGSPlaneQuery::Internals {
  vtkNew<vtkMatrix4x4> planeToRAS, outputToRAS;
  vtkSmartPointer<vtkAbstractTransform> rasToModel; // null: identity
  std::unique_ptr<innergs::PlaneSampler> sampler;
  std::shared_ptr<const innergs::GaussianField> field; // the field and options that the sampler was made for
  int threads = 0;
  std::string instructionSet, device;

  vtkSmartPointer<vtkMatrix4x4> deviationToRAS; // null: the image's own
  std::unique_ptr<innergs::ThreadPool> pool;    // for the standard deviation

  std::vector<innergs::Vec3> pointsOf(const innergs::Affine3& toRAS, int columns, int rows,
                                      const std::stop_token& stop) const;
};

/// The pixel centres (LPS mm), mapped to the model by the transform. On this thread, as not every transform's
/// inverse is thread-safe.
std::vector<innergs::Vec3> vtkInnerGSPlaneQuery::Internals::pointsOf(const innergs::Affine3& toRAS,
                                                                     int columns, int rows,
                                                                     const std::stop_token& stop) const {
  using innergs::Vec3;
  std::vector<Vec3> points;
  points.reserve(static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows));
  if (rasToModel) rasToModel->Update();
  for (int y = 0; y < rows; ++y) {
    if (stop.stop_requested()) throw innergs::Error(innergs::ErrorCode::Cancelled, "The query was stopped.");
    for (int x = 0; x < columns; ++x) {
      const Vec3 at = toRAS({static_cast<double>(x), static_cast<double>(y), 0});
      Vec3 there = at;
      if (rasToModel) rasToModel->InternalTransformPoint(at.data(), there.data());
      points.push_back(innergs::vtk::flipped(there));
    }
  }
  return points;
}

vtkInnerGSPlaneQuery::vtkInnerGSPlaneQuery() : Work(std::make_unique<Internals>()) {
  this->Device = "cpu";
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(2);
}
vtkInnerGSPlaneQuery::~vtkInnerGSPlaneQuery() = default;

int vtkInnerGSPlaneQuery::FillInputPortInformation(int port, vtkInformation* information) {
  if (port == 0) return this->Superclass::FillInputPortInformation(port, information);
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  return 1;
}

void vtkInnerGSPlaneQuery::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Dimensions: " << this->Dimensions[0] << " " << this->Dimensions[1] << "\n";
  os << indent << "Spacing: " << this->Spacing[0] << " " << this->Spacing[1] << "\n";
  os << indent << "Centred: " << this->Centred << "\n";
  os << indent << "QueryMilliseconds: " << this->QueryMilliseconds << "\n";
  os << indent << "PlaneToRASMatrix:\n";
  this->Work->planeToRAS->PrintSelf(os, indent.GetNextIndent());
}

void vtkInnerGSPlaneQuery::SetPlaneToRASMatrix(vtkMatrix4x4* planeToRAS) {
  if (!planeToRAS) {
    vtkErrorMacro(<< "The plane's matrix is missing: give a 4x4 matrix to RAS.");
    return;
  }
  for (int i = 0; i < 16; ++i)
    if (planeToRAS->GetElement(i / 4, i % 4) != this->Work->planeToRAS->GetElement(i / 4, i % 4)) {
      this->Work->planeToRAS->DeepCopy(planeToRAS);
      this->Modified();
      return;
    }
}

vtkMatrix4x4* vtkInnerGSPlaneQuery::GetPlaneToRASMatrix() {
  return this->Work->planeToRAS;
}

void vtkInnerGSPlaneQuery::SetTransformToModel(vtkAbstractTransform* rasToModel) {
  if (rasToModel == this->Work->rasToModel) return;
  this->Work->rasToModel = rasToModel;
  this->Modified();
}

vtkAbstractTransform* vtkInnerGSPlaneQuery::GetTransformToModel() {
  return this->Work->rasToModel;
}

void vtkInnerGSPlaneQuery::SetStandardDeviationData(vtkImageData* deviation) {
  if (deviation)
    this->SetInputDataObject(1, deviation);
  else
    this->RemoveAllInputConnections(1);
}

void vtkInnerGSPlaneQuery::SetStandardDeviationIJKToRASMatrix(vtkMatrix4x4* ijkToRAS) {
  if (innergs::vtk::assignCopy(this->Work->deviationToRAS, ijkToRAS)) this->Modified();
}

vtkImageData* vtkInnerGSPlaneQuery::GetOutput() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(0));
}

vtkImageData* vtkInnerGSPlaneQuery::GetOutputStandardDeviation() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}

vtkSmartPointer<vtkImageData> vtkInnerGSPlaneQuery::Query() {
  this->Modified(); // the last output was handed over
  this->Update();
  if (this->GetAborted() || !this->GetErrorMessage().empty()) return nullptr;
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->ShallowCopy(this->GetOutput());
  this->GetOutput()->Initialize();
  return image;
}

vtkMatrix4x4* vtkInnerGSPlaneQuery::GetOutputIJKToRASMatrix() {
  return this->Work->outputToRAS;
}

vtkMTimeType vtkInnerGSPlaneQuery::GetMTime() {
  const vtkMTimeType place = this->Work->rasToModel ? this->Work->rasToModel->GetMTime() : 0;
  return std::max({this->Superclass::GetMTime(), this->Work->planeToRAS->GetMTime(), place});
}

void vtkInnerGSPlaneQuery::RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  const int extent[6] = {0, this->Dimensions[0] - 1, 0, this->Dimensions[1] - 1, 0, 0};
  for (int port = 0; port < (inputs[1]->GetNumberOfInformationObjects() > 0 ? 2 : 1); ++port) {
    vtkInformation* output = outputs->GetInformationObject(port);
    output->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent, 6);
    vtkDataObject::SetPointDataActiveScalarInfo(output, VTK_FLOAT, 1);
  }
}

void vtkInnerGSPlaneQuery::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  using innergs::Affine3;
  using innergs::Vec3;
  const auto begun = std::chrono::steady_clock::now();
  Internals& work = *this->Work;
  const auto field = this->RequireModel(inputs)->GetField();
  if (!work.sampler || work.field != field || work.threads != this->NumberOfThreads ||
      work.instructionSet != this->InstructionSet || work.device != this->Device) {
    work.sampler.reset();
    work.pool.reset();
    work.sampler = std::make_unique<innergs::PlaneSampler>(
        field, this->NumberOfThreads, this->InstructionSet,
        innergs::DeviceChoice(this->Device, this->InstructionSet).makeField(*field));
    work.field = field;
    work.threads = this->NumberOfThreads;
    work.instructionSet = this->InstructionSet;
    work.device = this->Device;
  }
  for (const double s : this->Spacing)
    if (!std::isfinite(s) || s <= 0)
      throw innergs::Error(innergs::ErrorCode::InvalidArgument,
                           "The plane's pixel spacing must be finite and above zero.");
  Affine3 pixels; // → plane
  pixels.linear = innergs::diagonal({this->Spacing[0], this->Spacing[1], 1});
  if (this->Centred)
    pixels.offset = {-0.5 * (this->Dimensions[0] - 1) * this->Spacing[0],
                     -0.5 * (this->Dimensions[1] - 1) * this->Spacing[1], 0};
  const Affine3 toRAS = innergs::vtk::affineOf(work.planeToRAS, "The plane to RAS matrix") * pixels;
  // The image's axes are unit vectors, however the matrix scales; shear in the matrix shears them as well.
  innergs::GridGeometry grid;
  const Affine3 toLPS = innergs::vtk::flipped(toRAS);
  grid.size = {this->Dimensions[0], this->Dimensions[1], 1};
  grid.origin = toLPS.offset;
  for (int a = 0; a < 3; ++a) {
    const Vec3 axis = column(toLPS.linear, a);
    grid.spacing[a] = innergs::norm(axis);
    for (int i = 0; i < 3; ++i)
      grid.direction[i][a] = axis[i] / grid.spacing[a];
  }
  if (grid.size[0] < 1 || grid.size[1] < 1)
    throw innergs::Error(innergs::ErrorCode::InvalidArgument, "The plane must have at least one pixel.");
  vtkImageData* image = vtkImageData::GetData(outputs);
  float* pixelsOut = innergs::vtk::allocateFloats(image, grid, this->GeometryInImage);
  const std::span<float> out{pixelsOut, static_cast<std::size_t>(grid.voxelCount())};
  if (auto* linear = vtkLinearTransform::SafeDownCast(work.rasToModel); linear || !work.rasToModel) {
    const Affine3 toModel =
        linear ? innergs::vtk::affineOf(linear->GetMatrix(), "The transform to the model") : Affine3();
    work.sampler->sample(innergs::vtk::flipped(toModel * toRAS), this->Dimensions[0], this->Dimensions[1],
                         out, this->GetStopToken());
  } else {
    innergs::RenderOptions options;
    options.threads = work.threads;
    options.instructionSet = work.instructionSet;
    options.stop = this->GetStopToken();
    const std::vector<float> values = renderPoints(
        *work.field, work.pointsOf(toRAS, this->Dimensions[0], this->Dimensions[1], options.stop), options);
    std::copy(values.begin(), values.end(), out.begin());
  }
  vtkImageData* onPlane = vtkImageData::GetData(outputs, 1);
  onPlane->Initialize();
  if (vtkImageData* deviation = vtkImageData::GetData(inputs[1])) {
    const std::stop_token stop = this->GetStopToken();
    if (!work.pool) work.pool = std::make_unique<innergs::ThreadPool>(work.threads);
    work.pool->setStop(stop);
    innergs::vtk::sampleUncertainty(deviation, work.deviationToRAS,
                                    work.pointsOf(toRAS, this->Dimensions[0], this->Dimensions[1], stop),
                                    grid, this->GeometryInImage, *work.pool, onPlane);
  }
  innergs::vtk::toMatrix(toRAS, work.outputToRAS);
  this->QueryMilliseconds =
      std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begun).count();
}
