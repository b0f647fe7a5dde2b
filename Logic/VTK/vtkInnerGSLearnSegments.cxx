#include "vtkInnerGSLearnSegments.h"

#include "Core/Base/Error.h"
#include "Core/Base/PathText.h"
#include "Core/Device/FeatureDeviceChoice.h"
#include "Core/Features/Teacher.h"
#include "Core/Render/Render.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "Onnx/DenseNetwork.h"
#include "vtkInnerGSModel.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix4x4.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"
#include "vtkVariant.h"

#include <map>
#include <vector>

vtkStandardNewMacro(vtkInnerGSLearnSegments);

struct vtkInnerGSLearnSegments::Internals {
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS, featuresToRAS; // null: the image's own
  std::map<int, std::string> names;
  std::vector<innergs::TextEmbedding> texts;

  std::vector<innergs::SegmentName> segmentNames() const;
  innergs::NamedLabels labelsOf(vtkImageData* image, bool sparse, const std::stop_token& stop) const;
};

namespace {

vtkSmartPointer<vtkMatrix4x4> copyOf(vtkMatrix4x4* matrix) {
  if (!matrix) return nullptr;
  auto copy = vtkSmartPointer<vtkMatrix4x4>::New();
  copy->DeepCopy(matrix);
  return copy;
}

} // namespace

vtkInnerGSLearnSegments::vtkInnerGSLearnSegments() : Work(std::make_unique<Internals>()) {
  this->SetNumberOfInputPorts(3);
}
vtkInnerGSLearnSegments::~vtkInnerGSLearnSegments() = default;

void vtkInnerGSLearnSegments::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SparseSlices: " << this->SparseSlices << "\n";
  os << indent << "NumberOfChannels: " << this->NumberOfChannels << "\n";
  os << indent << "NumberOfIterations: " << this->NumberOfIterations << "\n";
  os << indent << "NetworkFile: " << this->NetworkFile << "\n";
  os << indent << "NetworkRange: " << this->NetworkRange[0] << " " << this->NetworkRange[1] << "\n";
  os << indent << "NetworkSpacing: " << this->NetworkSpacing << "\n";
  os << indent << "TextEmbeddings: " << this->Work->texts.size() << "\n";
  for (const auto& [label, name] : this->Work->names)
    os << indent << "Segment " << label << ": " << name << "\n";
}

int vtkInnerGSLearnSegments::FillInputPortInformation(int port, vtkInformation* information) {
  if (port == 0) return this->Superclass::FillInputPortInformation(port, information);
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // our own message says that it is missing
  return 1;
}

int vtkInnerGSLearnSegments::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkInnerGSModel");
  return 1;
}

void vtkInnerGSLearnSegments::SetLabels(vtkImageData* labels, vtkMatrix4x4* ijkToRAS) {
  this->SetInputData(1, labels);
  this->Work->ijkToRAS = copyOf(ijkToRAS);
  this->Modified();
}

void vtkInnerGSLearnSegments::SetSegmentName(int label, const std::string& name) {
  if (this->GetSegmentName(label) == name) return;
  if (name.empty())
    this->Work->names.erase(label);
  else
    this->Work->names[label] = name;
  this->Modified();
}

std::string vtkInnerGSLearnSegments::GetSegmentName(int label) {
  const auto found = this->Work->names.find(label);
  return found == this->Work->names.end() ? "" : found->second;
}

void vtkInnerGSLearnSegments::RemoveAllSegmentNames() {
  if (this->Work->names.empty()) return;
  this->Work->names.clear();
  this->Modified();
}

vtkInnerGSModel* vtkInnerGSLearnSegments::GetOutput() {
  return vtkInnerGSModel::SafeDownCast(this->GetOutputDataObject(0));
}

void vtkInnerGSLearnSegments::SetFeatures(vtkImageData* features, vtkMatrix4x4* ijkToRAS) {
  this->SetInputData(2, features);
  this->Work->featuresToRAS = copyOf(ijkToRAS);
  this->Modified();
}

void vtkInnerGSLearnSegments::SetTextEmbedding(const std::string& text, vtkDataArray* values) {
  std::vector<float> numbers;
  for (vtkIdType n = 0; values && n < values->GetNumberOfValues(); ++n)
    numbers.push_back(static_cast<float>(values->GetVariantValue(n).ToDouble()));
  auto& texts = this->Work->texts;
  std::erase_if(texts, [&](const auto& one) { return one.name == text; });
  if (!numbers.empty()) texts.push_back({text, std::move(numbers)});
  this->Modified();
}

int vtkInnerGSLearnSegments::GetNumberOfTextEmbeddings() {
  return static_cast<int>(this->Work->texts.size());
}

void vtkInnerGSLearnSegments::RemoveAllTextEmbeddings() {
  if (this->Work->texts.empty()) return;
  this->Work->texts.clear();
  this->Modified();
}

innergs::NamedLabels vtkInnerGSLearnSegments::Internals::labelsOf(vtkImageData* image, bool sparse,
                                                                  const std::stop_token& stop) const {
  const std::string what = "The labelmap";
  innergs::vtk::checkVoxels(image, what);
  innergs::Volume volume{innergs::vtk::gridOf(image, ijkToRAS, what), {}};
  volume.voxels = innergs::vtk::voxelsOf(image, {{0, 0, 0}, volume.geometry.size}, what, stop);
  innergs::NamedLabels given{innergs::labelmapOf(volume), segmentNames()};
  if (sparse) given.labels = innergs::withSparseSlices(given.labels);
  return given;
}

std::vector<innergs::SegmentName> vtkInnerGSLearnSegments::Internals::segmentNames() const {
  using innergs::Error;
  using innergs::ErrorCode;
  if (names.empty())
    throw Error(ErrorCode::InvalidArgument,
                "The labels have no names: name them, e.g. SetSegmentName(1, \"liver\").");
  std::vector<innergs::SegmentName> all;
  for (const auto& [label, name] : names) {
    if (label < 1 || label > 65535)
      throw Error(ErrorCode::InvalidArgument, "The segment \"" + name + "\" has the label " +
                                                  std::to_string(label) + ": labels are 1 to 65535.");
    all.push_back({static_cast<std::uint16_t>(label), name});
  }
  return all;
}

void vtkInnerGSLearnSegments::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  using innergs::Error;
  using innergs::ErrorCode;
  vtkInnerGSModel* model = this->RequireModel(inputs);
  vtkImageData* labels = vtkImageData::GetData(inputs[1]);
  vtkImageData* features = vtkImageData::GetData(inputs[2]);
  if (int{labels != nullptr} + int{features != nullptr} + int{!this->NetworkFile.empty()} > 1)
    throw Error(ErrorCode::InvalidArgument,
                "There are several teachers: give a labelmap, a feature volume or a network.");
  const std::stop_token stop = this->GetStopToken();
  const auto& field = *model->GetField();
  innergs::Teacher teacher;
  if (!this->NetworkFile.empty()) {
    innergs::DenseNetworkOptions options;
    options.spacing = this->NetworkSpacing;
    if (this->NetworkRange[0] != this->NetworkRange[1])
      options.range = innergs::ValueRange{static_cast<float>(this->NetworkRange[0]),
                                          static_cast<float>(this->NetworkRange[1])};
    options.threads = this->NumberOfThreads;
    options.stop = stop;
    options.progress = [this](double fraction) { this->UpdateProgress(fraction); };
    this->SetProgressText("Running the network");
    innergs::RenderOptions rendering;
    rendering.threads = this->NumberOfThreads;
    rendering.stop = stop;
    teacher = innergs::networkTeacher(
        innergs::pathOf(this->NetworkFile), innergs::render(field, field.region(), rendering),
        this->Work->texts.empty() ? this->Work->segmentNames() : std::vector<innergs::SegmentName>(),
        this->Work->texts, options);
  } else if (features) {
    const std::string what = "The feature volume";
    innergs::DenseTeacher dense;
    dense.features.geometry = innergs::vtk::gridOf(features, this->Work->featuresToRAS, what);
    dense.features.channels = innergs::vtk::componentsOf(features, what, stop);
    dense.texts = this->Work->texts;
    teacher = std::move(dense);
  } else if (labels) {
    teacher = this->Work->labelsOf(labels, this->SparseSlices, stop);
  } else {
    throw Error(ErrorCode::NoData, "There are no labels to learn from: set a labelmap, a feature volume or a "
                                   "network.");
  }
  innergs::FeatureTraining training;
  training.channels = this->NumberOfChannels;
  training.iterations = this->NumberOfIterations;
  training.threads = this->NumberOfThreads;
  training.stop = stop;
  training.devices = std::make_shared<innergs::FeatureDeviceChoice>(this->Device);
  training.progress = [this](double fraction) { this->UpdateProgress(fraction); };
  this->SetProgressText("Learning segments");
  auto learned = std::make_shared<const innergs::FeatureModel>(innergs::trainFrom(field, teacher, training));
  vtkInnerGSModel::GetData(outputs, 0)->SetCoreModel(model->GetCoreModel(), std::move(learned));
}
