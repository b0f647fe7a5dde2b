#include "ModelWriting.h"

#include "IO/FilePath.h"
#include "Queries.h"
#include "StorageTask.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkNew.h>

#include <filesystem>

namespace innergs::mrml {

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
  runStorage(
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

} // namespace innergs::mrml
