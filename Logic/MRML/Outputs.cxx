#include "Outputs.h"

#include "Core/Error.h"
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
#include <vtkTable.h>

#include <cmath>
#include <cstdio>

namespace innergs::mrml {
namespace {

/// A chosen node that is still in the scene, else a new one.
template <class Node>
vtkSmartPointer<Node> outputNode(Node* chosen, bool wasChosen, vtkMRMLScene* scene, const char* className,
                                 const std::string& name, bool& replaced) {
  if (chosen && chosen->GetScene() == scene) return chosen;
  replaced = replaced || wasChosen;
  return Node::SafeDownCast(addNode(scene, className, name));
}

std::string decibels(double psnr) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", psnr);
  return std::isnan(psnr) ? "" : text;
}

void setProvenance(vtkMRMLNode* node, const Task& task) {
  MRMLNodeModifyBlocker blocker(node);
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

vtkSmartPointer<vtkMRMLNode> addNode(vtkMRMLScene* scene, const char* className, const std::string& name) {
  const auto node = vtkSmartPointer<vtkMRMLNode>::Take(scene->CreateNodeByClass(className));
  if (!node)
    throw Error(ErrorCode::InvalidArgument, std::string("The scene does not know ") + className + ".");
  node->SetName(scene->GenerateUniqueName(name).c_str());
  scene->AddNode(node);
  return node;
}

void setVolume(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
               vtkMRMLVolumeNode* like) {
  // Observers of what follows may remove the node or drop the scene.
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> alive = node;
  const vtkSmartPointer<vtkMRMLScene> scene = node->GetScene();
  const vtkSmartPointer<vtkMRMLVolumeNode> likeAlive = like;
  MRMLNodeModifyBlocker blocker(node);
  if (node->GetParentTransformNode()) node->SetAndObserveTransformNodeID(nullptr); // results are in the world
  vtkNew<vtkImageData> own; // the maker's output may be written again
  own->ShallowCopy(image);
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  if (node->GetDisplayNode() || !scene || node->GetScene() != scene) return;
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
  scene->AddNode(display);
  if (node->GetScene() == scene && display->GetScene() == scene)
    node->SetAndObserveDisplayNodeID(display->GetID());
}

void leaveHierarchy(vtkMRMLNode* node, vtkMRMLScene* scene) {
  const bool ours = node->GetAttribute("InnerGS.Version") || node->GetNodeReferenceID("InnerGSModel");
  if (!ours || !scene || scene->IsClosing()) return;
  const vtkSmartPointer<vtkMRMLSubjectHierarchyNode> hierarchy =
      vtkMRMLSubjectHierarchyNode::SafeDownCast(scene->GetFirstNodeByClass("vtkMRMLSubjectHierarchyNode"));
  if (!hierarchy) return;
  const vtkIdType item = hierarchy->GetItemByDataNode(node);
  if (item != vtkMRMLSubjectHierarchyNode::INVALID_ITEM_ID) hierarchy->RemoveItem(item, false, false);
}

void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling) {
  if (!node || !sibling || !node->GetScene() || sibling->GetScene() != node->GetScene()) return;
  const vtkSmartPointer<vtkMRMLNode> alive[] = {node, sibling};
  const vtkSmartPointer<vtkMRMLScene> scene = node->GetScene();
  vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene); // makes one; observers may remove it, and us
  const vtkSmartPointer<vtkMRMLSubjectHierarchyNode> hierarchy =
      vtkMRMLSubjectHierarchyNode::SafeDownCast(scene->GetFirstNodeByClass("vtkMRMLSubjectHierarchyNode"));
  if (!hierarchy || node->GetScene() != scene || sibling->GetScene() != scene) return;
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

Outputs makeOutputs(const Task& task, vtkMRMLScene* scene) {
  const std::string base = task.inputNames.substr(0, task.inputNames.find("; "));
  // What can fail comes first: then either all outputs are made or none is touched.
  vtkNew<vtkInnerGSModel> content;
  content->ShallowCopy(task.filter->GetOutputModel());
  vtkNew<vtkImageData> image;
  image->ShallowCopy(task.filter->GetOutputImage());
  const vtkSmartPointer<vtkTable> quality = task.report ? makeQualityTable(*task.report) : nullptr;

  // Every change of a node is an event, whose observers may remove nodes and clear or drop the scene.
  const auto there = [&](vtkMRMLNode* node) { return node && !task.discard && node->GetScene() == scene; };
  const auto input = [&]() -> vtkMRMLVolumeNode* {
    return there(task.firstInput) ? task.firstInput.Get() : nullptr;
  };
  Outputs made;
  made.model = outputNode(task.model.Get(), !task.newModel, scene, "vtkMRMLInnerGSModelNode",
                          base + " InnerGS model", made.replaced);
  if (there(made.model) && made.model->GetParentTransformNode())
    made.model->SetAndObserveTransformNodeID(nullptr);
  if (there(made.model)) setProvenance(made.model, task);
  if (there(made.model)) made.model->SetModel(content);
  if (there(made.model)) placeBeside(made.model, input());
  if (task.discard) return made;

  made.volume = outputNode(task.volume.Get(), !task.newVolume, scene, "vtkMRMLScalarVolumeNode",
                           base + " InnerGS", made.replaced);
  if (there(made.volume)) setProvenance(made.volume, task);
  if (there(made.volume)) setVolume(made.volume, image, task.filter->GetOutputIJKToRASMatrix(), input());
  if (there(made.volume) && there(made.model))
    made.volume->SetNodeReferenceID("InnerGSModel", made.model->GetID());
  if (there(made.volume)) placeBeside(made.volume, input());
  if (quality && !task.discard)
    made.table = outputNode(task.table.Get(), !task.newTable, scene, "vtkMRMLTableNode",
                            base + " InnerGS quality", made.replaced);
  if (there(made.table)) setProvenance(made.table, task);
  if (there(made.table)) setQuality(made.table, quality, *task.report);
  if (there(made.table) && there(made.model))
    made.table->SetNodeReferenceID("InnerGSModel", made.model->GetID());
  if (there(made.table) && there(made.volume))
    made.table->SetNodeReferenceID("InnerGSVolume", made.volume->GetID());
  if (there(made.table)) placeBeside(made.table, input());
  // Removed since they were made.
  if (!there(made.model)) made.model = nullptr;
  if (!there(made.volume)) made.volume = nullptr;
  if (!there(made.table)) made.table = nullptr;
  return made;
}

} // namespace innergs::mrml
