#include "vtkInnerGSReconstruct.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/TimeEstimate.h"
#include "IO/N4Correction.h"
#include "ImageVoxels.h"
#include "ReconstructInputs.h"
#include "SettingsAccess.h"
#include "SliceTable.h"
#include "UncertaintyImage.h"
#include "vtkInnerGSModel.h"

#include "vtkDataObject.h"
#include "vtkDoubleArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkNew.h"
#include "vtkObjectFactory.h"
#include "vtkStreamingDemandDrivenPipeline.h"
#include "vtkTable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

vtkStandardNewMacro(vtkInnerGSReconstruct);

using innergs::Error;
using innergs::ErrorCode;

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::string progressText(const innergs::Progress& p) {
  std::string text = innergs::phaseName(p.phase);
  const bool fitting = p.phase == innergs::Phase::Fitting;
  if (fitting || (resultIsComplete(p.phase) && p.iterations > 0))
    text += innergs::formatted(", iteration %d of %d", p.iteration, p.iterations);
  if (fitting) text += innergs::formatted(", %.1f dB", p.trainingPsnr);
  if (p.phase != innergs::Phase::Done && p.remaining >= 1)
    text += innergs::formatted(", about %.0f s left", std::ceil(p.remaining));
  return text;
}

} // namespace

struct vtkInnerGSReconstruct::Internals {
  innergs::Settings settings;
  innergs::vtk::ReconstructInputs inputs;
  innergs::vtk::ReferenceGrid reference;
  vtkSmartPointer<vtkMatrix4x4> regionToRAS;
  vtkSmartPointer<vtkInnerGSModel> resume;
  std::optional<innergs::ReconstructionInput> snapshot;
  vtkNew<vtkMatrix4x4> outputToRAS, previewToRAS;
  vtkNew<vtkImageData> preview;
  innergs::Phase phase = innergs::Phase::Preparing;
  std::vector<std::string> warnings;
  vtkSmartPointer<vtkTable> slices = vtkSmartPointer<vtkTable>::New();
};

vtkInnerGSReconstruct::vtkInnerGSReconstruct()
    : TrainingPSNR(kNaN), HeldOutPSNR(kNaN), UncertaintyCoverage(kNaN), Work(std::make_unique<Internals>()) {
  this->SetNumberOfInputPorts(2);
  this->SetNumberOfOutputPorts(3);
}

vtkInnerGSReconstruct::~vtkInnerGSReconstruct() = default;

void vtkInnerGSReconstruct::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Settings: " << innergs::settingsText(this->GetSettings(), this->HeldOutFraction) << "\n";
  os << indent << "OutputSpacing: " << this->OutputSpacing[0] << " " << this->OutputSpacing[1] << " "
     << this->OutputSpacing[2] << "\n";
  os << indent << "EstimateUncertainty: " << this->EstimateUncertainty << "\n";
  os << indent << "UsedSettings: " << this->UsedSettings << "\n";
  os << indent << "TrainingPSNR: " << this->TrainingPSNR << "\n";
  os << indent << "HeldOutPSNR: " << this->HeldOutPSNR << "\n";
}

int vtkInnerGSReconstruct::FillInputPortInformation(int /*port*/, vtkInformation* information) {
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // not needed with a snapshot
  information->Set(vtkAlgorithm::INPUT_IS_REPEATABLE(), 1);
  return 1;
}

int vtkInnerGSReconstruct::FillOutputPortInformation(int port, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), port == 0 ? "vtkInnerGSModel" : "vtkImageData");
  return 1;
}

//------------------------------------------------------------------------------
// Settings.

vtkInnerGSFilterSettingsMacro(vtkInnerGSReconstruct);

//------------------------------------------------------------------------------
// Per-input properties.

template <class Change>
void vtkInnerGSReconstruct::ChangeInput(int index, Change change) {
  if (auto* input = this->Work->inputs.at(index); !input)
    vtkErrorMacro(<< "There is no input with the index " << index << ": give 0 or more.");
  else if (change(*input))
    this->Modified();
}

#define innergsInputMacro(Property, member, Type, Given)                                                     \
  void vtkInnerGSReconstruct::SetInput##Property(int index, Given value) {                                   \
    this->ChangeInput(index, [&](auto& input) { return std::exchange(input.member, value) != value; });      \
  }                                                                                                          \
  Type vtkInnerGSReconstruct::GetInput##Property(int index) {                                                \
    return this->Work->inputs.get(index).member;                                                             \
  }
innergsInputMacro(SliceThickness, thickness, double, double);
innergsInputMacro(SliceProfile, profile, int, int);
innergsInputMacro(SliceAxis, axis, int, int);
innergsInputMacro(Name, name, std::string, const std::string&);
#undef innergsInputMacro

void vtkInnerGSReconstruct::SetInputIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS) {
  this->ChangeInput(index, [&](auto& input) { return innergs::vtk::assignCopy(input.ijkToRAS, ijkToRAS); });
}

void vtkInnerGSReconstruct::SetInputSlicePoses(int index, vtkDoubleArray* poses) {
  this->ChangeInput(index, [&](auto& input) {
    return std::exchange(input.poses, vtkSmartPointer<vtkDoubleArray>(poses)) != poses;
  });
}

vtkDoubleArray* vtkInnerGSReconstruct::GetInputSlicePoses(int index) {
  return this->Work->inputs.get(index).poses;
}

vtkMatrix4x4* vtkInnerGSReconstruct::GetInputIJKToRASMatrix(int index) {
  auto* input = this->Work->inputs.at(index);
  return input ? input->ijkToRAS.Get() : nullptr;
}

//------------------------------------------------------------------------------
// Common properties.

void vtkInnerGSReconstruct::ClearInputs() {
  this->RemoveAllInputConnections(0);
  this->RemoveAllInputConnections(1);
  this->Work->inputs = {};
  this->Work->snapshot.reset();
  this->Modified();
}

void vtkInnerGSReconstruct::SetMaskData(vtkImageData* mask) {
  if (mask)
    this->SetInputDataObject(1, mask);
  else
    this->RemoveAllInputConnections(1);
}

void vtkInnerGSReconstruct::AddMaskData(vtkImageData* mask) {
  this->AddInputDataObject(1, mask);
}

void vtkInnerGSReconstruct::SetMaskIJKToRASMatrix(vtkMatrix4x4* ijkToRAS) {
  this->SetMaskIJKToRASMatrix(0, ijkToRAS);
}

void vtkInnerGSReconstruct::SetMaskIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS) {
  if (index < 0 || index > 65535) {
    vtkErrorMacro(<< "There is no mask with the index " << index << ": give 0 or more.");
    return;
  }
  auto& matrices = this->Work->inputs.masksToRAS;
  const auto at = static_cast<std::size_t>(index);
  if (at >= matrices.size()) matrices.resize(at + 1);
  if (innergs::vtk::assignCopy(matrices[at], ijkToRAS)) this->Modified();
}

void vtkInnerGSReconstruct::SetRegionToRASMatrix(vtkMatrix4x4* regionToRAS) {
  if (innergs::vtk::assignCopy(this->Work->regionToRAS, regionToRAS)) this->Modified();
}

vtkMatrix4x4* vtkInnerGSReconstruct::GetRegionToRASMatrix() {
  return this->Work->regionToRAS;
}

void vtkInnerGSReconstruct::SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ,
                                             int dimensionK) {
  const int dimensions[3] = {dimensionI, dimensionJ, dimensionK}, first[3] = {0, 0, 0};
  if (this->Work->reference.set(ijkToRAS, dimensions, first)) this->Modified();
}

void vtkInnerGSReconstruct::SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  if (this->Work->reference.set(image, ijkToRAS)) this->Modified();
}

bool vtkInnerGSReconstruct::HasReferenceGrid() {
  return this->Work->reference.given();
}

void vtkInnerGSReconstruct::SetResumeModel(vtkInnerGSModel* model) {
  if (this->Work->resume == model) return;
  this->Work->resume = model;
  this->Modified();
}

vtkInnerGSModel* vtkInnerGSReconstruct::GetResumeModel() {
  return this->Work->resume;
}

//------------------------------------------------------------------------------
// Outputs and reports.

vtkInnerGSModel* vtkInnerGSReconstruct::GetOutputModel() {
  return vtkInnerGSModel::SafeDownCast(this->GetOutputDataObject(0));
}
vtkImageData* vtkInnerGSReconstruct::GetOutputImage() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(1));
}
vtkImageData* vtkInnerGSReconstruct::GetOutputStandardDeviation() {
  return vtkImageData::SafeDownCast(this->GetOutputDataObject(2));
}
vtkMatrix4x4* vtkInnerGSReconstruct::GetOutputIJKToRASMatrix() {
  return this->Work->outputToRAS;
}
vtkMatrix4x4* vtkInnerGSReconstruct::GetPreviewIJKToRASMatrix() {
  return this->Work->previewToRAS;
}
vtkImageData* vtkInnerGSReconstruct::GetPreviewImage() {
  return this->Work->preview;
}
std::string vtkInnerGSReconstruct::GetPhase() {
  return innergs::phaseName(this->Work->phase);
}
int vtkInnerGSReconstruct::GetNumberOfWarnings() {
  return static_cast<int>(this->Work->warnings.size());
}
vtkTable* vtkInnerGSReconstruct::GetSliceTable() {
  return this->Work->slices;
}

std::string vtkInnerGSReconstruct::GetWarning(int index) {
  return index >= 0 && index < this->GetNumberOfWarnings() ? this->Work->warnings[index] : "";
}

//------------------------------------------------------------------------------
// Work.

innergs::vtk::OutputChoice vtkInnerGSReconstruct::MakeOutputChoice() {
  innergs::vtk::OutputChoice choice;
  choice.reference = &this->Work->reference;
  std::copy_n(this->OutputSpacing, 3, choice.spacing.begin());
  if (this->UseRegion) choice.box = innergs::vtk::boxOf(this->Region, this->Work->regionToRAS);
  return choice;
}

innergs::ReconstructionInput vtkInnerGSReconstruct::MakeInput(const std::vector<vtkImageData*>& images,
                                                              const std::vector<vtkImageData*>& masks,
                                                              std::stop_token stop) {
  innergs::ReconstructionInput input = this->Work->inputs.read(images, masks, this->MakeOutputChoice(), stop);
  input.heldOutFraction = this->HeldOutFraction;
  input.uncertainty = this->EstimateUncertainty;
  input.n4 = innergs::correctByN4;
  if (this->Work->resume) {
    if (this->Work->resume->IsEmpty())
      throw Error(ErrorCode::NoData, "The model to resume has no Gaussians: choose another or none.");
    input.resume = this->Work->resume->GetCoreModel();
  }
  return input;
}

std::vector<vtkImageData*> vtkInnerGSReconstruct::GetInputImages(int port) {
  std::vector<vtkImageData*> images;
  for (int i = 0; i < this->GetNumberOfInputConnections(port); ++i)
    images.push_back(vtkImageData::SafeDownCast(this->GetInputDataObject(port, i)));
  return images;
}

bool vtkInnerGSReconstruct::TakeSnapshot() {
  this->Work->snapshot.reset();
  const bool done = this->Guard(
      [&] { this->Work->snapshot = this->MakeInput(this->GetInputImages(0), this->GetInputImages(1), {}); });
  if (!done) return false;
  this->RemoveAllInputConnections(0);
  this->RemoveAllInputConnections(1);
  this->Modified();
  return true;
}

bool vtkInnerGSReconstruct::HasSnapshot() {
  return this->Work->snapshot.has_value();
}

bool vtkInnerGSReconstruct::WithOutline(const std::function<void(const innergs::ReconstructionInput&)>& use) {
  if (this->Work->snapshot) {
    use(*this->Work->snapshot);
    return true;
  }
  const std::vector<vtkImageData*> images = this->GetInputImages(0);
  if (images.empty()) return false;
  innergs::ReconstructionInput input = this->Work->inputs.outline(images, this->MakeOutputChoice());
  input.heldOutFraction = this->HeldOutFraction;
  input.uncertainty = this->EstimateUncertainty;
  use(input);
  return true;
}

vtkTypeInt64 vtkInnerGSReconstruct::EstimateMemory() {
  vtkTypeInt64 bytes = 0;
  this->Guard([&] {
    this->WithOutline([&](const auto& input) { bytes = estimateMemory(input, this->GetSettings()); });
  });
  return bytes;
}

double vtkInnerGSReconstruct::EstimateSeconds() {
  double seconds = 0;
  this->Guard([&] {
    this->WithOutline([&](const auto& input) { seconds = estimateSeconds(input, this->GetSettings()); });
  });
  return seconds;
}

std::string vtkInnerGSReconstruct::DescribeDevice() {
  try {
    const innergs::Settings s = this->GetSettings();
    return innergs::DeviceChoice(s.device, s.instructionSet, s.selection).use.reason;
  } catch (const Error& error) {
    return error.what();
  }
}

void vtkInnerGSReconstruct::RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  innergs::GridGeometry grid;
  if (this->Work->snapshot)
    grid = *this->Work->snapshot->outputGrid;
  else {
    std::vector<vtkNew<vtkImageData>> placed(
        static_cast<std::size_t>(inputs[0]->GetNumberOfInformationObjects()));
    std::vector<vtkImageData*> images;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      innergs::vtk::placeAsAnnounced(inputs[0]->GetInformationObject(static_cast<int>(i)), placed[i]);
      images.push_back(placed[i]);
    }
    if (images.empty()) return;
    grid = *this->Work->inputs.outline(images, this->MakeOutputChoice()).outputGrid;
  }
  innergs::vtk::announceImage(outputs->GetInformationObject(1), grid, this->GeometryInImage);
  if (this->EstimateUncertainty)
    innergs::vtk::announceImage(outputs->GetInformationObject(2), grid, this->GeometryInImage);
}

void vtkInnerGSReconstruct::ReportProgress(const innergs::Progress& p) {
  this->Work->phase = p.phase;
  this->CurrentIteration = p.iteration;
  this->TotalIterations = p.iterations;
  this->CurrentLoss = p.loss;
  this->TrainingPSNR = p.trainingPsnr;
  this->HeldOutPSNR = p.heldOutPsnr;
  this->CurrentGaussians = static_cast<vtkIdType>(p.gaussians);
  this->ElapsedSeconds = p.elapsed;
  this->RemainingSeconds = p.remaining;
  if (!p.note.empty())
    (p.phase == innergs::Phase::Predicting ? this->PredictionNote : this->DeviceNote) =
        p.note; // sent once, but kept for later readers
  this->SetProgressText(progressText(p).c_str());
  this->UpdateProgress(p.fraction);
}

innergs::ReconstructionResult vtkInnerGSReconstruct::Reconstruct(innergs::ReconstructionInput&& input,
                                                                 const innergs::Settings& settings,
                                                                 const std::stop_token& stop) {
  innergs::ReconstructionJob job(std::move(input), settings);
  job.onProgress([this](const innergs::Progress& p) { this->ReportProgress(p); });
  if (this->HasObserver(PreviewEvent))
    job.onPreview([this](const innergs::Volume& volume) { this->ReportPreview(volume); });
  return job.run(stop);
}

void vtkInnerGSReconstruct::ReportPreview(const innergs::Volume& volume) {
  // A new image each time, as an observer may keep the last one.
  vtkNew<vtkImageData> image;
  std::copy(volume.voxels.begin(), volume.voxels.end(),
            innergs::vtk::allocateFloats(image, volume.geometry, this->GeometryInImage));
  this->Work->preview->ShallowCopy(image);
  innergs::vtk::toMatrix(volume.geometry, this->Work->previewToRAS);
  this->InvokeEvent(PreviewEvent, image);
}

void vtkInnerGSReconstruct::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  Internals& work = *this->Work;
  work.warnings.clear();
  for (std::string* last :
       {&this->UsedSettings, &this->UsedInstructionSet, &this->UsedDevice, &this->AgreementNote,
        &this->PredictionNote, &this->ProfileNote, &this->DeviceNote, &this->UncertaintyNote})
    last->clear();
  this->UncertaintyCoverage = kNaN;
  this->NumberOfHeldOutSlices = 0;
  this->QualityState = QualityNotAsked;
  this->ReportProgress({});
  const std::stop_token stop = this->GetStopToken();
  const innergs::Settings settings = this->GetSettings();
  checkSettings(settings);
  innergs::checkHeldOutFraction(this->HeldOutFraction);
  innergs::ReconstructionInput input;
  if (work.snapshot) {
    input = std::move(*work.snapshot);
    work.snapshot.reset();
  } else {
    std::array<std::vector<vtkImageData*>, 2> images;
    for (int port = 0; port < 2; ++port)
      for (int i = 0; i < inputs[port]->GetNumberOfInformationObjects(); ++i)
        images[port].push_back(vtkImageData::GetData(inputs[port], i));
    input = this->MakeInput(images[0], images[1], stop);
  }
  innergs::ReconstructionResult result = this->Reconstruct(std::move(input), settings, stop);
  // A stop while the quality was judged ended only that.
  if (result.cancelled || (stop.stop_requested() && result.judging == innergs::Judging::NotAsked)) {
    if (!this->KeepModelWhenAborted || result.model->field.gaussians.empty())
      throw Error(ErrorCode::Cancelled, "Stopped on request.");
    this->Aborted = true;
  }
  this->CurrentIteration = result.iterations;
  this->CurrentGaussians = static_cast<vtkIdType>(result.model->field.size());
  this->TrainingPSNR = result.trainingPsnr;
  this->HeldOutPSNR = result.heldOutPsnr;
  this->NumberOfHeldOutSlices = static_cast<int>(result.heldOutSlices);
  this->QualityState = static_cast<int>(result.judging);
  this->ElapsedSeconds = result.seconds;
  this->RemainingSeconds = 0;
  this->FitSeconds = result.fitSeconds;
  this->Noise = result.noise;
  this->NumberOfNonFiniteVoxels = static_cast<vtkIdType>(result.nonFiniteVoxels);
  work.warnings = std::move(result.warnings);
  work.slices = innergs::vtk::makeSliceTable(innergs::foundSlices(result));
  this->SlicesMoved = result.sliceMotion.moved;
  this->UsedSettings = innergs::settingsText(result.settings, this->HeldOutFraction);
  this->UsedInstructionSet = result.instructionSet;
  this->UsedDevice = result.device.id;
  this->AgreementNote = innergs::agreementSentence(result.agreement);
  this->PredictionNote = result.prediction;
  this->ProfileNote = result.profiles.sentence;
  this->DeviceNote = result.device.reason;
  vtkInnerGSModel::GetData(outputs, 0)->SetCoreModel(result.model);
  if (this->Aborted) return;
  vtkImageData* image = vtkImageData::GetData(outputs, 1);
  std::copy(result.volume.voxels.begin(), result.volume.voxels.end(),
            innergs::vtk::allocateFloats(image, result.volume.geometry, this->GeometryInImage));
  innergs::vtk::toMatrix(result.volume.geometry, work.outputToRAS);
  // A mask's box is known only now: the announced grid was not cropped to it.
  vtkInformation* output = outputs->GetInformationObject(1);
  innergs::vtk::announceImage(output, result.volume.geometry, this->GeometryInImage);
  output->Set(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), image->GetExtent(), 6);
  vtkImageData* deviation = vtkImageData::GetData(outputs, 2);
  deviation->Initialize();
  vtkInformation* second = outputs->GetInformationObject(2);
  if (const auto& u = result.uncertainty) {
    innergs::vtk::setUncertainty(deviation, *u, this->GeometryInImage);
    innergs::vtk::announceImage(second, u->deviation.geometry, this->GeometryInImage);
    this->UncertaintyCoverage = u->coverage;
    this->UncertaintyNote = innergs::uncertaintySentence(*u);
  } else {
    second->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), deviation->GetExtent(), 6);
  }
  second->Set(vtkStreamingDemandDrivenPipeline::UPDATE_EXTENT(), deviation->GetExtent(), 6);
}
