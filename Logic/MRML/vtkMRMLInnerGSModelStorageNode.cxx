#include "vtkMRMLInnerGSModelStorageNode.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLMessageCollection.h>
#include <vtkMRMLScene.h>

#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkStringArray.h>

vtkMRMLNodeNewMacro(vtkMRMLInnerGSModelStorageNode);

namespace {

/// Whether the name is that of a PLY file; throws when it is neither that nor a model's.
bool isPly(const std::filesystem::path& path) {
  const std::string extension = innergs::fullExtension(path);
  if (extension != ".ply" && extension != ".innergs")
    throw innergs::Error(innergs::ErrorCode::InvalidArgument,
                         innergs::quoted(path) +
                             " is not a model's file name: let it end with .innergs or .ply.");
  return extension == ".ply";
}

std::shared_ptr<const void> contentOf(vtkMRMLInnerGSModelNode* node) {
  if (node->IsDynamic()) return node->GetDynamicModel()->GetField();
  return node->GetModel()->GetCoreModel();
}

std::shared_ptr<const innergs::FeatureModel> featuresOf(vtkMRMLInnerGSModelNode* node) {
  return node->IsDynamic() ? node->GetDynamicModel()->GetFeatures() : node->GetModel()->GetFeatures();
}

const std::string kPrefix = "InnerGS."; // of the attributes that say what a model was made from

innergs::ModelNotes notesOf(vtkMRMLNode* node) {
  innergs::ModelNotes notes;
  for (const std::string& name : node->GetAttributeNames())
    if (name.compare(0, kPrefix.size(), kPrefix) == 0)
      notes[name.substr(kPrefix.size())] = node->GetAttribute(name.c_str());
  return notes;
}

void setNotes(vtkMRMLNode* node, const innergs::ModelNotes& notes) {
  for (const auto& [name, text] : notesOf(node)) // of an earlier model
    if (notes.find(name) == notes.end()) node->RemoveAttribute((kPrefix + name).c_str());
  for (const auto& [name, text] : notes)
    node->SetAttribute((kPrefix + name).c_str(), text.c_str());
}

} // namespace

vtkMRMLInnerGSModelStorageNode::vtkMRMLInnerGSModelStorageNode() {
  this->DefaultWriteFileExtension = "innergs";
}
vtkMRMLInnerGSModelStorageNode::~vtkMRMLInnerGSModelStorageNode() = default;

bool vtkMRMLInnerGSModelStorageNode::CanReadInReferenceNode(vtkMRMLNode* node) {
  return node && node->IsA("vtkMRMLInnerGSModelNode");
}

bool vtkMRMLInnerGSModelStorageNode::Holds(vtkMRMLInnerGSModelNode* node) {
  return node && !node->IsEmpty() && this->Stored.lock() == contentOf(node) &&
         this->StoredFeatures.lock() == featuresOf(node);
}

void vtkMRMLInnerGSModelStorageNode::NoteStored(vtkMRMLInnerGSModelNode* node) {
  this->Remember(node);
  this->StoredTime->Modified();
}

void vtkMRMLInnerGSModelStorageNode::Remember(vtkMRMLInnerGSModelNode* node) {
  this->Stored = contentOf(node);
  this->StoredFeatures = featuresOf(node);
}

void vtkMRMLInnerGSModelStorageNode::InitializeSupportedReadFileTypes() {
  this->SupportedReadFileTypes->InsertNextValue("InnerGS model (.innergs)");
  this->SupportedReadFileTypes->InsertNextValue("Gaussians (.ply)");
}

void vtkMRMLInnerGSModelStorageNode::InitializeSupportedWriteFileTypes() {
  this->SupportedWriteFileTypes->InsertNextValue("InnerGS model (.innergs)");
  this->SupportedWriteFileTypes->InsertNextValue("Gaussians (.ply)");
}

int vtkMRMLInnerGSModelStorageNode::ReadDataInternal(vtkMRMLNode* node) {
  this->ErrorMessage.clear();
  this->ErrorCode = 0;
  auto* modelNode = vtkMRMLInnerGSModelNode::SafeDownCast(node);
  const std::string name = this->GetFullNameFromFileName();
  try {
    if (!modelNode || name.empty())
      throw innergs::Error(innergs::ErrorCode::InvalidArgument,
                           "There is no file name to read a model from: choose a file.");
    const std::filesystem::path path = innergs::pathOf(name);
    isPly(path); // or a model by its name
    const innergs::AnyModel read = innergs::readAnyModel(path);
    MRMLNodeModifyBlocker blocker(modelNode);
    if (!read.notes.empty()) setNotes(modelNode, read.notes); // else what the scene's file says stays
    if (read.field) {
      vtkNew<vtkInnerGSDynamicModel> model;
      model->SetField(read.field, read.features);
      modelNode->SetDynamicModel(model);
    } else {
      vtkNew<vtkInnerGSModel> model;
      model->SetCoreModel(read.model, read.features);
      modelNode->SetModel(model);
    }
    this->Remember(modelNode);
    return 1;
  } catch (...) {
    return this->Fail();
  }
}

/// Of the exception being handled.
int vtkMRMLInnerGSModelStorageNode::Fail() {
  const innergs::Failure failure = innergs::failureOf();
  this->ErrorMessage = failure.sentence;
  this->ErrorCode = vtkInnerGSAlgorithm::ToErrorNumber(failure.code);
  this->GetUserMessages()->AddMessage(vtkCommand::ErrorEvent, this->ErrorMessage);
  vtkErrorMacro(<< this->ErrorMessage);
  return 0;
}

int vtkMRMLInnerGSModelStorageNode::WriteData(vtkMRMLNode* node) {
  const int written = this->Superclass::WriteData(node);
  auto* model = vtkMRMLInnerGSModelNode::SafeDownCast(node);
  if (written && this->Partly && model && model->GetStorageNode() == this) model->StorableModified();
  return written;
}

int vtkMRMLInnerGSModelStorageNode::WriteDataInternal(vtkMRMLNode* node) {
  this->ErrorMessage.clear();
  this->ErrorCode = 0;
  this->Partly = false;
  auto* modelNode = vtkMRMLInnerGSModelNode::SafeDownCast(node);
  const std::string name = this->GetFullNameFromFileName();
  try {
    if (!modelNode || modelNode->IsEmpty())
      throw innergs::Error(innergs::ErrorCode::NoData,
                           "The model is empty: reconstruct or load one before saving it.");
    if (name.empty())
      throw innergs::Error(innergs::ErrorCode::InvalidArgument,
                           "There is no file name to save the model under: choose one.");
    const std::filesystem::path path = innergs::pathOf(name);
    const auto core = modelNode->GetModel()->GetCoreModel();
    const auto features = featuresOf(modelNode);
    if (isPly(path)) {
      innergs::writePly(core->field, path);
      const std::string dropped = innergs::droppedByPly(core->field, features ? features->classes() - 1 : 0);
      this->Partly =
          !dropped.empty() || !core->complete() || core->iteration > 0 || !notesOf(modelNode).empty();
      this->Partly = this->Partly || modelNode->IsDynamic();
      if (this->Partly)
        this->GetUserMessages()->AddMessage(
            vtkCommand::WarningEvent,
            (dropped.empty() ? dropped : dropped + " ") +
                "A PLY file also lacks the state of the fit and the model's sources: until it is saved as an "
                ".innergs file, the model counts as unsaved.");
    } else if (modelNode->IsDynamic()) {
      innergs::writeDynamicModel(*modelNode->GetDynamicModel()->GetField(), path, notesOf(modelNode), {},
                                 features.get());
    } else {
      innergs::writeModel(*core, path, notesOf(modelNode), features.get());
    }
    this->Remember(modelNode);
    if (this->Partly) this->Stored.reset();
    return 1;
  } catch (...) {
    return this->Fail();
  }
}
