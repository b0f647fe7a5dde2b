#include "ModelNodes.h"

#include "Core/Base/Error.h"
#include "IO/FilePath.h"
#include "Outputs.h"
#include "Queries.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSToPolyData.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>

#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

#include <filesystem>
#include <functional>

namespace innergs::mrml {

namespace {

/// Turns a storage node's failure into an Error, with its own code and sentence if it has one.
void transfer(vtkMRMLInnerGSModelStorageNode* storage, const std::function<int()>& task, ErrorCode code,
              const std::string& otherwise) {
  vtkNew<vtkCallbackCommand> quiet;
  const unsigned long tag = storage->AddObserver(vtkCommand::ErrorEvent, quiet);
  const int done = task();
  storage->RemoveObserver(tag);
  if (done) return;
  if (const std::string message = storage->GetErrorMessage(); !message.empty())
    throw Error(vtkInnerGSAlgorithm::FromErrorNumber(storage->GetErrorCode()), message);
  throw Error(code, otherwise);
}

} // namespace

ModelReading::ModelReading(const std::string& fileName)
    : file_(fileName), storage_(vtkSmartPointer<vtkMRMLInnerGSModelStorageNode>::New()),
      node_(vtkSmartPointer<vtkMRMLInnerGSModelNode>::New()) {
  storage_->SetFileName(fileName.c_str());
}

ModelReading::~ModelReading() = default;

void ModelReading::read() {
  transfer(
      storage_, [this] { return storage_->ReadData(node_); }, ErrorCode::FileFormat,
      "'" + file_ + "' could not be read: choose an .innergs or .ply file.");
}

vtkMRMLInnerGSModelNode* ModelReading::addTo(vtkMRMLScene* scene) {
  if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to load into: set one.");
  const std::string file = storage_->GetFileNameWithoutExtension(file_.c_str());
  const std::string name = file.substr(file.find_last_of("/\\") + 1);
  node_->SetName(scene->GenerateUniqueName(name.empty() ? "InnerGS model" : name).c_str());
  scene->AddNode(storage_);
  scene->AddNode(node_);
  node_->SetAndObserveStorageNodeID(storage_->GetID());
  return node_;
}

ModelWriting::ModelWriting(vtkMRMLInnerGSModelNode* model, const std::string& fileName)
    : model_(model), storage_(vtkSmartPointer<vtkMRMLInnerGSModelStorageNode>::New()),
      copy_(vtkSmartPointer<vtkMRMLInnerGSModelNode>::New()) {
  modelOf(model); // throws without a model
  if (fileName.empty())
    throw Error(ErrorCode::InvalidArgument,
                "There is no file name to save the model under: choose one that ends with .innergs or .ply.");
  if (model->IsDynamic()) {
    vtkNew<vtkInnerGSDynamicModel> content;
    content->ShallowCopy(model->GetDynamicModel());
    copy_->SetDynamicModel(content);
  } else {
    vtkNew<vtkInnerGSModel> content;
    content->ShallowCopy(model->GetModel());
    copy_->SetModel(content);
  }
  for (const std::string& name : model->GetAttributeNames())
    copy_->SetAttribute(name.c_str(), model->GetAttribute(name.c_str()));
  const std::filesystem::path path = pathOf(fileName);
  // Only a model file keeps everything: after a PLY file the model still counts as unsaved.
  own_ = fullExtension(path) == ".innergs";
  // A relative name refers to the working folder; a storage node in a scene would take the scene's.
  file_ = utf8(std::filesystem::absolute(path));
  storage_->SetFileName(file_.c_str());
}

ModelWriting::~ModelWriting() = default;

void ModelWriting::write() {
  transfer(
      storage_, [this] { return storage_->WriteData(copy_); }, ErrorCode::Io,
      "'" + file_ + "' could not be written: choose a file name that ends with .innergs or .ply.");
}

void ModelWriting::note() {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> model = model_.Get(); // an observer may remove it
  if (!own_ || !model || !model->GetScene() || model->IsEmpty() || !storage_->Holds(model)) return;
  if (!model->GetStorageNode()) model->AddDefaultStorageNode();
  const vtkSmartPointer<vtkMRMLInnerGSModelStorageNode> storage =
      vtkMRMLInnerGSModelStorageNode::SafeDownCast(model->GetStorageNode());
  if (!storage) return;
  storage->SetFileName(file_.c_str());
  storage->NoteStored(model);
}

vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output) {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> kept = model; // an observer may remove it
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(model));
  filter->SetMaximumNumberOfGaussians(maximum);
  run(filter);
  // Observers of the following may remove the node.
  vtkSmartPointer<vtkMRMLModelNode> made = output;
  if (!made) {
    if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a model to: set one.");
    const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + " Gaussians";
    made = vtkMRMLModelNode::SafeDownCast(addNode(scene, "vtkMRMLModelNode", name));
    if (made->GetScene()) made->CreateDefaultDisplayNodes();
    placeBeside(made, model);
  }
  made->SetAndObserveTransformNodeID(model->GetTransformNodeID());
  vtkNew<vtkPolyData> own;
  own->ShallowCopy(filter->GetOutput());
  setProvenance(made, model);
  made->SetAndObservePolyData(own);
  return made;
}

} // namespace innergs::mrml
