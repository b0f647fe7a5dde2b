#include "ModelNodes.h"

#include "Core/Error.h"
#include "IO/FilePath.h"
#include "Outputs.h"
#include "Queries.h"
#include "vtkInnerGSToPolyData.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>

#include <filesystem>
#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkPolyData.h>

namespace innergs::mrml {

vtkMRMLInnerGSModelNode* loadModel(vtkMRMLScene* scene, const std::string& fileName) {
  if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to load into: set one.");
  vtkNew<vtkMRMLInnerGSModelStorageNode> storage;
  vtkNew<vtkMRMLInnerGSModelNode> node;
  vtkNew<vtkCallbackCommand> quiet;
  const unsigned long tag = storage->AddObserver(vtkCommand::ErrorEvent, quiet);
  storage->SetFileName(fileName.c_str());
  const int read = storage->ReadData(node);
  storage->RemoveObserver(tag);
  if (!read)
    throw Error(ErrorCode::FileFormat,
                storage->GetErrorMessage().empty()
                    ? "'" + fileName + "' could not be read: choose an .innergs or .ply file."
                    : storage->GetErrorMessage());
  const std::string file = storage->GetFileNameWithoutExtension(fileName.c_str());
  const std::string name = file.substr(file.find_last_of("/\\") + 1);
  node->SetName(scene->GenerateUniqueName(name.empty() ? "InnerGS model" : name).c_str());
  scene->AddNode(storage);
  scene->AddNode(node);
  node->SetAndObserveStorageNodeID(storage->GetID());
  return node;
}

void saveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  modelOf(model);
  if (fileName.empty())
    throw Error(ErrorCode::InvalidArgument,
                "There is no file name to save the model under: choose one that ends with .innergs or .ply.");
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> kept = model; // an observer may remove it
  // Only a model file keeps everything: a PLY file does not make the model a saved one.
  vtkSmartPointer<vtkMRMLInnerGSModelStorageNode> storage;
  const std::u8string utf8(fileName.begin(), fileName.end());
  const bool own = fullExtension(utf8) == ".innergs" && model->GetScene();
  const bool first = own && !model->GetStorageNode();
  if (first) model->AddDefaultStorageNode();
  if (own) storage = vtkMRMLInnerGSModelStorageNode::SafeDownCast(model->GetStorageNode());
  if (!storage) storage = vtkSmartPointer<vtkMRMLInnerGSModelStorageNode>::New();
  const std::string before = storage->GetFileName() ? storage->GetFileName() : "";
  vtkNew<vtkCallbackCommand> quiet;
  const unsigned long tag = storage->AddObserver(vtkCommand::ErrorEvent, quiet);
  // A relative name means the working folder, not, as for a storage node in a scene, the scene's.
  const std::u8string absolute = std::filesystem::absolute(std::filesystem::path(utf8)).u8string();
  storage->SetFileName(std::string(absolute.begin(), absolute.end()).c_str());
  const int written = storage->WriteData(model);
  storage->RemoveObserver(tag);
  if (!written) {
    storage->SetFileName(before.empty() ? nullptr : before.c_str());
    if (first && storage->GetScene()) storage->GetScene()->RemoveNode(storage);
  }
  if (!written)
    throw Error(ErrorCode::Io,
                storage->GetErrorMessage().empty()
                    ? "'" + fileName +
                          "' could not be written: choose a file name that ends with .innergs or .ply."
                    : storage->GetErrorMessage());
}

vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output) {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> kept = model; // an observer may remove it
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(model));
  filter->SetMaximumNumberOfGaussians(maximum);
  run(filter);
  // Observers of what follows may remove the node.
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
