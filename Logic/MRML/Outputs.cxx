#include "Outputs.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Base/NumberText.h"
#include "QualityTable.h"
#include "UncertaintyImage.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSubjectHierarchyNode.h>
#include <vtkMRMLTableNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkTable.h>

#include <cmath>
#include <functional>

namespace innergs::mrml {
namespace {

/// Creates a node outside the scene.
vtkSmartPointer<vtkMRMLNode> makeNode(vtkMRMLScene* scene, const char* className, const std::string& name) {
  auto node = vtkSmartPointer<vtkMRMLNode>::Take(scene->CreateNodeByClass(className));
  if (!node)
    throw Error(ErrorCode::InvalidArgument, std::string("The scene does not know ") + className + ".");
  node->SetName(scene->GenerateUniqueName(name).c_str());
  return node;
}

/// Sets `made` to the chosen node if it is still in the scene, else to a new one; does so before adding it,
/// as an observer may throw.
template <class Node>
void takeOutput(vtkSmartPointer<Node>& made, Node* chosen, bool wasChosen, vtkMRMLScene* scene,
                const char* className, const std::string& name, bool& replaced) {
  if (chosen && chosen->GetScene() == scene) {
    made = chosen;
    return;
  }
  replaced = replaced || wasChosen;
  made = Node::SafeDownCast(makeNode(scene, className, name));
  scene->AddNode(made);
}

std::string decibels(double psnr) {
  return std::isnan(psnr) ? "" : formatted("%.3f", psnr);
}

void setJobProvenance(vtkMRMLNode* node, const Task& task) {
  MRMLNodeModifyBlocker blocker(node);
  node->SetAttribute("InnerGS.Version", INNERGS_VERSION);
  node->SetAttribute("InnerGS.Inputs", joined(task.inputNames).c_str());
  node->SetAttribute("InnerGS.Mask", task.maskName.empty() ? nullptr : task.maskName.c_str());
  node->SetAttribute("InnerGS.Settings", task.filter->GetUsedSettings().c_str());
  node->SetAttribute("InnerGS.InstructionSet", task.filter->GetUsedInstructionSet().c_str());
  node->SetAttribute("InnerGS.Device", task.filter->GetUsedDevice().c_str());
  node->SetAttribute("InnerGS.TrainingPSNR", decibels(task.filter->GetTrainingPSNR()).c_str());
  const std::string heldOut = decibels(task.filter->GetHeldOutPSNR());
  node->SetAttribute("InnerGS.HeldOutPSNR", heldOut.empty() ? nullptr : heldOut.c_str());
  const std::string slices = std::to_string(task.filter->GetNumberOfHeldOutSlices());
  node->SetAttribute("InnerGS.HeldOutSlices", heldOut.empty() ? nullptr : slices.c_str());
}

} // namespace

vtkSmartPointer<vtkMRMLNode> addNode(vtkMRMLScene* scene, const char* className, const std::string& name) {
  auto node = makeNode(scene, className, name);
  scene->AddNode(node);
  return node;
}

void setVolume(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
               vtkMRMLVolumeNode* like) {
  // Observers of the following changes may remove the node or delete the scene.
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> alive = node;
  const vtkSmartPointer<vtkMRMLScene> scene = node->GetScene();
  const vtkSmartPointer<vtkMRMLVolumeNode> likeAlive = like;
  MRMLNodeModifyBlocker blocker(node);
  if (node->GetParentTransformNode()) node->SetAndObserveTransformNodeID(nullptr); // results are in the world
  vtkNew<vtkImageData> own; // the filter may overwrite its own output
  own->ShallowCopy(image);
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  if (node->GetDisplayNode() || !scene || node->GetScene() != scene) return;
  auto* shown = like ? vtkMRMLScalarVolumeDisplayNode::SafeDownCast(like->GetDisplayNode()) : nullptr;
  if (!shown) {
    node->CreateDefaultDisplayNodes();
    return;
  }
  // Set completely before the image is shown through it: choosing a window automatically is slow for large
  // volumes.
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

void setDeviation(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
                  vtkMRMLVolumeNode* like) {
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> alive = node;
  const vtkSmartPointer<vtkMRMLScene> scene = node->GetScene();
  MRMLNodeModifyBlocker blocker(node);
  if (auto* scalar = vtkMRMLScalarVolumeNode::SafeDownCast(like); scalar && scalar->GetVoxelValueUnits())
    node->SetVoxelValueUnits(scalar->GetVoxelValueUnits());
  if (!node->GetDisplayNode() && scene) {
    vtkNew<vtkMRMLScalarVolumeDisplayNode> display;
    display->SetAutoWindowLevel(0);
    display->SetWindowLevelMinMax(0, vtk::usualDeviation(image));
    constexpr const char* kColours = "vtkMRMLColorTableNodeFileInferno.txt"; // where the application has them
    if (scene->GetNodeByID(kColours))
      display->SetAndObserveColorNodeID(kColours);
    else
      display->SetDefaultColorMap();
    scene->AddNode(display);
    if (node->GetScene() == scene && display->GetScene() == scene)
      node->SetAndObserveDisplayNodeID(display->GetID());
  }
  if (node->GetScene() == scene) setVolume(node, image, ijkToRAS);
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
  vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(scene); // creates one; observers may remove it, and us
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
  const std::string base = task.inputNames.front();
  vtkNew<vtkInnerGSModel> content;
  content->ShallowCopy(task.filter->GetOutputModel());
  vtkNew<vtkImageData> image;
  image->ShallowCopy(task.filter->GetOutputImage());
  vtkNew<vtkImageData> deviation;
  deviation->ShallowCopy(task.filter->GetOutputStandardDeviation());

  // Every change of a node is an event, whose observers may remove nodes, clear or delete the scene, or run
  // out of memory. So this goes step by step, and one failure does not affect the others.
  Outputs made;
  const auto step = [&](const std::function<void()>& what) {
    if (task.discard) return true;
    const std::string problem = sentenceOf(what);
    if (made.problem.empty()) made.problem = problem;
    return problem.empty();
  };
  const auto there = [&](vtkMRMLNode* node) { return node && !task.discard && node->GetScene() == scene; };
  const auto input = [&]() -> vtkMRMLVolumeNode* {
    return there(task.firstInput) ? task.firstInput.Get() : nullptr;
  };
  const auto take = [&](auto& node, auto* chosen, bool wasChosen, const char* className, const char* suffix) {
    const auto once = [&] {
      takeOutput(node, chosen, wasChosen, scene, className, base + suffix, made.replaced);
    };
    if (!step(once) && !there(node)) step(once);
  };
  vtkSmartPointer<vtkTable> quality;
  if (task.report) step([&] { quality = makeQualityTable(*task.report); });

  take(made.model, task.model.Get(), !task.newModel, "vtkMRMLInnerGSModelNode", " InnerGS model");
  if (there(made.model) && made.model->GetParentTransformNode())
    step([&] { made.model->SetAndObserveTransformNodeID(nullptr); });
  if (there(made.model)) step([&] { setJobProvenance(made.model, task); });
  if (there(made.model)) step([&] { made.model->SetModel(content); });
  if (there(made.model)) step([&] { placeBeside(made.model, input()); });
  if (task.discard) return made;

  take(made.volume, task.volume.Get(), !task.newVolume, "vtkMRMLScalarVolumeNode", " InnerGS");
  if (there(made.volume)) step([&] { setJobProvenance(made.volume, task); });
  if (there(made.volume))
    step([&] { setVolume(made.volume, image, task.filter->GetOutputIJKToRASMatrix(), input()); });
  if (there(made.volume) && there(made.model))
    step([&] { made.volume->SetNodeReferenceID("InnerGSModel", made.model->GetID()); });
  if (there(made.volume)) step([&] { placeBeside(made.volume, input()); });
  if (deviation->GetNumberOfPoints() > 0 && !task.discard)
    take(made.uncertainty, task.uncertainty.Get(), !task.newUncertainty, "vtkMRMLScalarVolumeNode",
         " InnerGS standard deviation");
  if (there(made.uncertainty)) step([&] { setJobProvenance(made.uncertainty, task); });
  if (there(made.uncertainty))
    step([&] {
      made.uncertainty->SetAttribute("InnerGS.Uncertainty", task.filter->GetUncertaintyNote().c_str());
    });
  if (there(made.uncertainty))
    step([&] { setDeviation(made.uncertainty, deviation, task.filter->GetOutputIJKToRASMatrix(), input()); });
  if (there(made.uncertainty) && there(made.model))
    step([&] { made.uncertainty->SetNodeReferenceID("InnerGSModel", made.model->GetID()); });
  if (there(made.uncertainty) && there(made.volume))
    step([&] { made.uncertainty->SetNodeReferenceID("InnerGSVolume", made.volume->GetID()); });
  if (there(made.uncertainty)) step([&] { placeBeside(made.uncertainty, input()); });
  if (there(made.uncertainty)) {
    auto* before = vtkMRMLLabelMapVolumeNode::SafeDownCast(made.uncertainty->GetNodeReference(kMeasuredRole));
    take(made.measured, before, before != nullptr, "vtkMRMLLabelMapVolumeNode", " InnerGS measured");
  }
  if (there(made.measured)) step([&] { setJobProvenance(made.measured, task); });
  if (there(made.measured))
    step([&] {
      setVolume(made.measured, vtk::measuredLabelmap(deviation), task.filter->GetOutputIJKToRASMatrix());
    });
  if (there(made.measured) && there(made.model))
    step([&] { made.measured->SetNodeReferenceID("InnerGSModel", made.model->GetID()); });
  if (there(made.measured)) step([&] { placeBeside(made.measured, input()); });
  if (there(made.uncertainty))
    step([&] {
      made.uncertainty->SetNodeReferenceID(kMeasuredRole,
                                           there(made.measured) ? made.measured->GetID() : nullptr);
    });
  if (there(made.model) && (there(made.uncertainty) || made.model->GetNodeReferenceID(kUncertaintyRole)))
    step([&] {
      made.model->SetNodeReferenceID(kUncertaintyRole,
                                     there(made.uncertainty) ? made.uncertainty->GetID() : nullptr);
    });
  if (quality && !task.discard)
    take(made.table, task.table.Get(), !task.newTable, "vtkMRMLTableNode", " InnerGS quality");
  if (there(made.table)) step([&] { setJobProvenance(made.table, task); });
  if (there(made.table)) step([&] { setQuality(made.table, quality, *task.report); });
  if (there(made.table) && there(made.model))
    step([&] { made.table->SetNodeReferenceID("InnerGSModel", made.model->GetID()); });
  if (there(made.table) && there(made.volume))
    step([&] { made.table->SetNodeReferenceID("InnerGSVolume", made.volume->GetID()); });
  if (there(made.table)) step([&] { placeBeside(made.table, input()); });
  vtkNew<vtkTable> slices;
  slices->ShallowCopy(task.filter->GetSliceTable());
  if (task.filter->GetSlicesMoved() && !task.discard) {
    vtkMRMLTableNode* none = nullptr;
    take(made.slices, none, false, "vtkMRMLTableNode", " InnerGS slices");
  }
  if (there(made.slices)) step([&] { setJobProvenance(made.slices, task); });
  if (there(made.slices)) step([&] { made.slices->SetAndObserveTable(slices); });
  if (there(made.slices) && there(made.model))
    step([&] { made.slices->SetNodeReferenceID("InnerGSModel", made.model->GetID()); });
  if (there(made.slices)) step([&] { placeBeside(made.slices, input()); });
  // Removed since they were created, or never filled.
  if (!there(made.model) || made.model->GetModel() != content.Get()) made.model = nullptr;
  if (there(made.volume) && task.newVolume && !made.volume->GetImageData())
    step([&] { scene->RemoveNode(made.volume); });
  if (!there(made.volume) || !made.volume->GetImageData()) made.volume = nullptr;
  if (!there(made.table)) made.table = nullptr;
  if (!there(made.slices)) made.slices = nullptr;
  if (!there(made.uncertainty) || !made.uncertainty->GetImageData()) made.uncertainty = nullptr;
  if (!there(made.measured) || !made.measured->GetImageData()) made.measured = nullptr;
  return made;
}

} // namespace innergs::mrml
