#include "vtkInnerGSDynamicReconstruct.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Motion/DynamicJob.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "PipelineTime.h"
#include "ReconstructInputs.h"
#include "SettingsAccess.h"

#include "vtkDoubleArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkObjectFactory.h"

#include <cmath>
#include <limits>

vtkStandardNewMacro(vtkInnerGSDynamicReconstruct);

using innergs::Error;
using innergs::ErrorCode;

namespace {
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
}

struct vtkInnerGSDynamicReconstruct::Internals {
  innergs::Settings settings; // without those that the base class holds
  std::vector<double> times;
  vtkSmartPointer<vtkDoubleArray> sliceTimes;
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS;
  innergs::Phase phase = innergs::Phase::Preparing;
};

vtkInnerGSDynamicReconstruct::vtkInnerGSDynamicReconstruct()
    : TrainingPSNR(kNotANumber), Work(std::make_unique<Internals>()) {}
vtkInnerGSDynamicReconstruct::~vtkInnerGSDynamicReconstruct() = default;

void vtkInnerGSDynamicReconstruct::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Settings: " << innergs::dynamicSettingsText(this->GetSettings()) << "\n";
  os << indent << "TrainingPSNR: " << this->TrainingPSNR << "\n";
  os << indent << "Choice: " << this->Choice << "\n";
  os << indent << "UsedDevice: " << this->UsedDevice << "\n";
  os << indent << "DeviceNote: " << this->DeviceNote << "\n";
  os << indent << "Notes: " << this->Notes << "\n";
}

vtkInnerGSFilterSettingsMacro(vtkInnerGSDynamicReconstruct);

int vtkInnerGSDynamicReconstruct::FillInputPortInformation(int, vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1);
  information->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  return 1;
}

int vtkInnerGSDynamicReconstruct::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkInnerGSDynamicModel");
  return 1;
}

void vtkInnerGSDynamicReconstruct::SetFrameTime(int index, double time) {
  if (index < 0) {
    vtkErrorMacro(<< "There is no frame with the index " << index << ": give 0 or more.");
    return;
  }
  std::vector<double>& times = this->Work->times;
  if (static_cast<std::size_t>(index) >= times.size()) times.resize(index + 1, kNotANumber);
  if (times[index] == time) return;
  times[index] = time;
  this->Modified();
}

double vtkInnerGSDynamicReconstruct::GetFrameTime(int index) {
  return index >= 0 && static_cast<std::size_t>(index) < this->Work->times.size() ? this->Work->times[index]
                                                                                  : kNotANumber;
}

void vtkInnerGSDynamicReconstruct::SetTimeStep(double interval, int numberOfFrames) {
  for (int f = 0; f < numberOfFrames; ++f)
    this->SetFrameTime(f, interval * f);
}

void vtkInnerGSDynamicReconstruct::SetSliceTimes(vtkDoubleArray* times) {
  if (times == this->Work->sliceTimes) return;
  this->Work->sliceTimes = times;
  this->Modified();
}

vtkDoubleArray* vtkInnerGSDynamicReconstruct::GetSliceTimes() {
  return this->Work->sliceTimes;
}

void vtkInnerGSDynamicReconstruct::SetIJKToRASMatrix(vtkMatrix4x4* ijkToRAS) {
  if (innergs::vtk::assignCopy(this->Work->ijkToRAS, ijkToRAS)) this->Modified();
}

vtkMatrix4x4* vtkInnerGSDynamicReconstruct::GetIJKToRASMatrix() {
  return this->Work->ijkToRAS;
}

void vtkInnerGSDynamicReconstruct::ClearInputs() {
  this->SetInputConnection(0, nullptr);
  this->Work->times.clear();
  this->Work->sliceTimes = nullptr;
  this->Work->ijkToRAS = nullptr;
  this->Modified();
}

vtkInnerGSDynamicModel* vtkInnerGSDynamicReconstruct::GetOutput() {
  return vtkInnerGSDynamicModel::SafeDownCast(this->GetOutputDataObject(0));
}

std::string vtkInnerGSDynamicReconstruct::GetPhase() {
  return innergs::phaseName(this->Work->phase);
}

void vtkInnerGSDynamicReconstruct::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  for (std::string* last : {&this->Choice, &this->Notes, &this->UsedDevice, &this->DeviceNote})
    last->clear();
  this->TrainingPSNR = kNotANumber;
  const std::stop_token stop = this->GetStopToken();
  innergs::TimeSeries series;
  series.name = this->SeriesName;
  const int frames = inputs[0]->GetNumberOfInformationObjects();
  if (frames == 0)
    throw Error(ErrorCode::NoData, "There are no frames: add one image per frame of the dynamic scan.");
  for (int f = 0; f < frames; ++f) {
    const std::string what = "Frame " + std::to_string(f) + " of " + this->SeriesName;
    vtkImageData* image = vtkImageData::GetData(inputs[0], f);
    innergs::vtk::checkVoxels(image, what);
    const innergs::GridGeometry grid = innergs::vtk::gridOf(image, this->Work->ijkToRAS, what);
    if (f == 0)
      series.geometry = grid;
    else if (!innergs::sameGrid(series.geometry, grid))
      throw Error(ErrorCode::Geometry, what + " lies on another grid than the first frame: resample all "
                                              "frames to one first.");
    series.frames.push_back(innergs::vtk::voxelsOf(image, {{0, 0, 0}, grid.size}, what, stop));
    series.times.push_back(this->GetFrameTime(f));
  }
  if (vtkDoubleArray* times = this->Work->sliceTimes; times && times->GetNumberOfValues() > 0)
    series.sliceTiming = {this->SliceAxis,
                          {times->GetPointer(0), times->GetPointer(0) + times->GetNumberOfValues()}};
  innergs::DynamicJob job(std::move(series), this->GetSettings());
  job.onProgress([this](const innergs::Progress& p) {
    this->Work->phase = p.phase;
    this->ElapsedSeconds = p.elapsed;
    this->RemainingSeconds = p.remaining;
    this->TrainingPSNR = p.trainingPsnr;
    if (!p.note.empty()) this->DeviceNote = p.note; // sent once, kept for later readers
    std::string text = innergs::phaseName(p.phase);
    if (p.remaining >= 1) text += innergs::formatted(", about %.0f s left", std::ceil(p.remaining));
    this->SetProgressText(text.c_str());
    this->UpdateProgress(p.fraction);
  });
  const innergs::DynamicResult result = job.run(stop);
  this->RemainingSeconds = 0;
  if (result.cancelled || stop.stop_requested()) {
    if (!this->KeepModelWhenAborted || !result.field)
      throw Error(ErrorCode::Cancelled, "Stopped on request.");
    this->Aborted = true;
  }
  this->Choice = result.choice;
  this->UsedDevice = result.device.id;
  this->DeviceNote = result.device.reason;
  for (const std::string& note : result.notes)
    this->Notes += (this->Notes.empty() ? "" : "\n") + note;
  this->TrainingPSNR = result.trainingPsnr;
  this->ElapsedSeconds = result.seconds;
  vtkInnerGSDynamicModel::GetData(outputs, 0)->SetField(result.field);
}
