#include "ModelReading.h"

#include "StorageTask.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkMRMLScene.h>

namespace innergs::mrml {

ModelReading::ModelReading(const std::string& fileName)
    : file_(fileName), storage_(vtkSmartPointer<vtkMRMLInnerGSModelStorageNode>::New()),
      node_(vtkSmartPointer<vtkMRMLInnerGSModelNode>::New()) {
  storage_->SetFileName(fileName.c_str());
}

ModelReading::~ModelReading() = default;

void ModelReading::read() {
  runStorage(
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

} // namespace innergs::mrml
