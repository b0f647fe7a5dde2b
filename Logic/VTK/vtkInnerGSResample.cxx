#include "vtkInnerGSResample.h"

#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"
#include "Core/Job/ReconstructionJob.h"
#include "Core/Render/Render.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "vtkInnerGSModel.h"

#include "vtkDataObject.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>

vtkStandardNewMacro(vtkInnerGSResample);

namespace {

constexpr std::int64_t kSlab = std::int64_t{1} << 23; // voxels rendered between two progress events

} // namespace

struct vtkInnerGSResample::Internals {
  innergs::vtk::ReferenceGrid reference;
  vtkNew<vtkMatrix4x4> outputToRAS;
};

vtkInnerGSResample::vtkInnerGSResample() : Work(std::make_unique<Internals>()) {}
vtkInnerGSResample::~vtkInnerGSResample() = default;

void vtkInnerGSResample::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "OutputSpacing: " << this->OutputSpacing[0] << " " << this->OutputSpacing[1] << " "
     << this->OutputSpacing[2] << "\n";
  os << indent << "ReferenceGrid: " << (this->Work->reference.given() ? "given" : "none") << "\n";
}

void vtkInnerGSResample::SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ,
                                          int dimensionK) {
  const int dimensions[3] = {dimensionI, dimensionJ, dimensionK}, first[3] = {0, 0, 0};
  if (this->Work->reference.set(ijkToRAS, dimensions, first)) this->Modified();
}

void vtkInnerGSResample::SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  if (this->Work->reference.set(image, ijkToRAS)) this->Modified();
}

bool vtkInnerGSResample::HasReferenceGrid() {
  return this->Work->reference.given();
}

vtkImageData* vtkInnerGSResample::GetOutput() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(0));
}

vtkMatrix4x4* vtkInnerGSResample::GetOutputIJKToRASMatrix() {
  return this->Work->outputToRAS;
}

void vtkInnerGSResample::RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  const auto field = this->RequireModel(inputs)->GetField();
  innergs::vtk::announceImage(
      outputs->GetInformationObject(0),
      innergs::vtk::outputGrid(field->region(), this->Work->reference, this->OutputSpacing),
      this->GeometryInImage);
}

void vtkInnerGSResample::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  const auto field = this->RequireModel(inputs)->GetField();
  innergs::checkField(*field);
  const innergs::GridGeometry grid =
      innergs::vtk::outputGrid(field->region(), this->Work->reference, this->OutputSpacing);
  const std::int64_t available = innergs::availableMemory();
  if (available > 0 && grid.voxelCount() > (available - (std::int64_t{1} << 28)) / 4)
    throw innergs::Error(
        innergs::ErrorCode::Memory,
        "The resampled volume does not fit into memory: choose a coarser spacing or a smaller grid.");
  innergs::RenderOptions options;
  options.threads = this->NumberOfThreads;
  options.instructionSet = this->InstructionSet;
  options.device = innergs::renderingDevice(this->Device, *field, grid.voxelCount(), this->InstructionSet);
  options.stop = this->GetStopToken();
  this->SetProgressText("Resampling");
  vtkImageData* image = vtkImageData::GetData(outputs);
  float* voxels = innergs::vtk::allocateFloats(image, grid, this->GeometryInImage);
  const std::int64_t plane = grid.size[0] * grid.size[1], slab = std::max<std::int64_t>(1, kSlab / plane);
  for (std::int64_t k = 0; k < grid.size[2]; k += slab) {
    const std::int64_t planes = std::min(slab, grid.size[2] - k);
    const innergs::Volume part =
        render(*field, cropped(grid, {0, 0, k}, {grid.size[0], grid.size[1], planes}), options);
    std::copy(part.voxels.begin(), part.voxels.end(), voxels + k * plane);
    this->UpdateProgress(static_cast<double>(k + planes) / static_cast<double>(grid.size[2]));
    if (options.stop.stop_requested()) // set by an observer
      throw innergs::Error(innergs::ErrorCode::Cancelled, "Stopped on request.");
  }
  innergs::vtk::toMatrix(grid, this->Work->outputToRAS);
}
