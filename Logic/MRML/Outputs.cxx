#include "Outputs.h"

#include "QualityTable.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSubjectHierarchyNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <cmath>
#include <cstdio>

namespace innergs::mrml {
namespace {

/// A chosen node that is still in the scene, or a new one where none was chosen; null when the chosen one is
/// gone.
template <class Node>
Node* outputNode(Node* chosen, bool isNew, vtkMRMLScene* scene, const char* className,
                 const std::string& name) {
  if (isNew) return Node::SafeDownCast(addNode(scene, className, name));
  return chosen && chosen->GetScene() == scene ? chosen : nullptr;
}

std::string decibels(double psnr) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", psnr);
  return std::isnan(psnr) ? "" : text;
}

void setProvenance(vtkMRMLNode* node, const Task& task) {
  node->SetAttribute("InnerGS.Version", INNERGS_VERSION);
  node->SetAttribute("InnerGS.Inputs", task.inputNames.c_str());
  node->SetAttribute("InnerGS.Settings", task.filter->GetUsedSettings().c_str());
  node->SetAttribute("InnerGS.InstructionSet", task.filter->GetUsedInstructionSet().c_str());
  node->SetAttribute("InnerGS.Device", task.filter->GetUsedDevice().c_str());
  node->SetAttribute("InnerGS.TrainingPSNR", decibels(task.filter->GetTrainingPSNR()).c_str());
  const std::string heldOut = decibels(task.filter->GetHeldOutPSNR());
  node->SetAttribute("InnerGS.HeldOutPSNR", heldOut.empty() ? nullptr : heldOut.c_str());
}

} // namespace

vtkMRMLNode* addNode(vtkMRMLScene* scene, const char* className, const std::string& name) {
  return scene->AddNewNodeByClass(className, scene->GenerateUniqueName(name));
}

void setVolume(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
               vtkMRMLVolumeNode* like) {
  MRMLNodeModifyBlocker blocker(node);
  if (node->GetParentTransformNode()) node->SetAndObserveTransformNodeID(nullptr); // results are in the world
  vtkNew<vtkImageData> own; // the maker's output may be written again
  own->ShallowCopy(image);
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  if (node->GetDisplayNode() || !node->GetScene()) return;
  auto* shown = like ? vtkMRMLScalarVolumeDisplayNode::SafeDownCast(like->GetDisplayNode()) : nullptr;
  if (!shown) {
    node->CreateDefaultDisplayNodes();
    return;
  }
  // Complete before the image is seen through it: choosing a window by itself takes long for large volumes.
  vtkNew<vtkMRMLScalarVolumeDisplayNode> display;
  display->SetAutoWindowLevel(0);
  display->SetWindowLevel(shown->GetWindow(), shown->GetLevel());
  if (shown->GetColorNodeID())
    display->SetAndObserveColorNodeID(shown->GetColorNodeID());
  else
    display->SetDefaultColorMap();
  node->GetScene()->AddNode(display);
  node->SetAndObserveDisplayNodeID(display->GetID());
}

void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling) {
  if (!node || !sibling || !node->GetScene() || sibling->GetScene() != node->GetScene()) return;
  auto* hierarchy = vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(node->GetScene());
  if (!hierarchy) return;
  const vtkIdType none = vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID;
  const vtkIdType siblingItem = hierarchy->GetItemByDataNode(sibling);
  const vtkIdType parent =
      siblingItem == none ? hierarchy->GetSceneItemID() : hierarchy->GetItemParent(siblingItem);
  const vtkIdType item = hierarchy->GetItemByDataNode(node);
  if (item == none)
    hierarchy->CreateItem(parent, node);
  else if (hierarchy->GetItemParent(item) != parent)
    hierarchy->SetItemParent(item, parent);
}

void makeOutputs(Task& task, vtkMRMLScene* scene, vtkMRMLScalarVolumeNode*& volume,
                 vtkMRMLInnerGSModelNode*& model, vtkMRMLTableNode*& table) {
  const std::string base = task.inputNames.substr(0, task.inputNames.find("; "));
  vtkMRMLVolumeNode* input =
      task.firstInput && task.firstInput->GetScene() == scene ? task.firstInput.Get() : nullptr;

  model =
      outputNode(task.model.Get(), task.newModel, scene, "vtkMRMLInnerGSModelNode", base + " InnerGS model");
  if (model) {
    vtkNew<vtkInnerGSModel> own;
    own->ShallowCopy(task.filter->GetOutputModel());
    if (model->GetParentTransformNode()) model->SetAndObserveTransformNodeID(nullptr);
    setProvenance(model, task);
    model->SetModel(own);
    placeBeside(model, input);
  }
  volume = outputNode(task.volume.Get(), task.newVolume, scene, "vtkMRMLScalarVolumeNode", base + " InnerGS");
  if (volume) {
    setProvenance(volume, task);
    setVolume(volume, task.filter->GetOutputImage(), task.filter->GetOutputIJKToRASMatrix(), input);
    if (model) volume->SetNodeReferenceID("InnerGSModel", model->GetID());
    placeBeside(volume, input);
  }
  if (task.report) {
    table = outputNode(task.table.Get(), task.newTable, scene, "vtkMRMLTableNode", base + " InnerGS quality");
    if (table) {
      setProvenance(table, task);
      fillQualityTable(table, *task.report);
      placeBeside(table, input);
    }
  }
}

} // namespace innergs::mrml
