#include "vtkInnerGSLearnSegments.h"

#include "Core/Base/Error.h"
#include "Core/Features/FeatureTraining.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "vtkInnerGSModel.h"

#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkInformationVector.h"
#include "vtkMatrix4x4.h"
#include "vtkObjectFactory.h"
#include "vtkSmartPointer.h"

#include <map>

vtkStandardNewMacro(vtkInnerGSLearnSegments);

struct vtkInnerGSLearnSegments::Internals {
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // null: the image's own
  std::map<int, std::string> names;
};

vtkInnerGSLearnSegments::vtkInnerGSLearnSegments() : Work(std::make_unique<Internals>()) {
  this->SetNumberOfInputPorts(2);
}
vtkInnerGSLearnSegments::~vtkInnerGSLearnSegments() = default;

void vtkInnerGSLearnSegments::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "SparseSlices: " << this->SparseSlices << "\n";
  os << indent << "NumberOfChannels: " << this->NumberOfChannels << "\n";
  os << indent << "NumberOfIterations: " << this->NumberOfIterations << "\n";
  for (const auto& [label, name] : this->Work->names)
    os << indent << "Segment " << label << ": " << name << "\n";
}

int vtkInnerGSLearnSegments::FillInputPortInformation(int port, vtkInformation* information) {
  if (port == 0) return this->Superclass::FillInputPortInformation(port, information);
  information->Set(vtkAlgorithm::INPUT_REQUIRED_DATA_TYPE(), "vtkImageData");
  information->Set(vtkAlgorithm::INPUT_IS_OPTIONAL(), 1); // a sentence of our own says that it is missing
  return 1;
}

int vtkInnerGSLearnSegments::FillOutputPortInformation(int, vtkInformation* information) {
  information->Set(vtkDataObject::DATA_TYPE_NAME(), "vtkInnerGSModel");
  return 1;
}

void vtkInnerGSLearnSegments::SetLabels(vtkImageData* labels, vtkMatrix4x4* ijkToRAS) {
  this->SetInputData(1, labels);
  this->Work->ijkToRAS = nullptr;
  if (ijkToRAS) {
    this->Work->ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
    this->Work->ijkToRAS->DeepCopy(ijkToRAS);
  }
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

void vtkInnerGSLearnSegments::RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) {
  using innergs::Error;
  using innergs::ErrorCode;
  vtkInnerGSModel* model = this->RequireModel(inputs);
  vtkImageData* image = vtkImageData::GetData(inputs[1]);
  if (!image) throw Error(ErrorCode::NoData, "There are no labels to learn from: set a labelmap.");
  if (this->Work->names.empty())
    throw Error(ErrorCode::InvalidArgument,
                "The labels have no names: name them, e.g. SetSegmentName(1, \"liver\").");
  std::vector<innergs::SegmentName> names;
  for (const auto& [label, name] : this->Work->names) {
    if (label < 1 || label > 65535)
      throw Error(ErrorCode::InvalidArgument, "The segment \"" + name + "\" has the label " +
                                                  std::to_string(label) + ": labels are 1 to 65535.");
    names.push_back({static_cast<std::uint16_t>(label), name});
  }
  const std::stop_token stop = this->GetStopToken();
  const std::string what = "The labelmap";
  innergs::vtk::checkVoxels(image, what);
  innergs::Volume volume{innergs::vtk::gridOf(image, this->Work->ijkToRAS, what), {}};
  volume.voxels = innergs::vtk::voxelsOf(image, {{0, 0, 0}, volume.geometry.size}, what, stop);
  innergs::Labelmap labels = innergs::labelmapOf(volume);
  if (this->SparseSlices) labels = innergs::withSparseSlices(labels);
  innergs::FeatureTraining training;
  training.channels = this->NumberOfChannels;
  training.iterations = this->NumberOfIterations;
  training.threads = this->NumberOfThreads;
  training.stop = stop;
  training.progress = [this](double fraction) { this->UpdateProgress(fraction); };
  this->SetProgressText("Learning segments");
  auto features = std::make_shared<const innergs::FeatureModel>(
      innergs::trainFeatures(*model->GetField(), labels, names, training));
  vtkInnerGSModel::GetData(outputs, 0)->SetCoreModel(model->GetCoreModel(), std::move(features));
}
