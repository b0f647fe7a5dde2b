#include "SceneChoices.h"

#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"

#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSelectionNode.h>
#include <vtkMRMLSliceCompositeNode.h>

#include <string>
#include <vector>

namespace innergs::mrml {
namespace {

constexpr const char* kParameters = "InnerGSParameters";
constexpr const char* kModel = "InnerGSModel";
constexpr const char* kBackground = "InnerGSBackground";

vtkMRMLNode* selectionOf(vtkMRMLScene* scene) {
  return scene ? scene->GetSingletonNode("Singleton", "vtkMRMLSelectionNode") : nullptr;
}

void refer(vtkMRMLNode* from, const char* role, vtkMRMLNode* to) {
  const char* now = from->GetNodeReferenceID(role);
  const std::string next = to && to->GetID() ? to->GetID() : "";
  if (next == (now ? now : "")) return; // no event
  from->SetNodeReferenceID(role, next.empty() ? nullptr : next.c_str());
}

template <class Node>
Node* referred(vtkMRMLNode* from, const char* role) {
  auto* node = Node::SafeDownCast(from ? from->GetNodeReference(role) : nullptr);
  return node && node->GetScene() == from->GetScene() ? node : nullptr;
}

} // namespace

void rememberChoices(vtkMRMLScene* scene, vtkMRMLInnerGSParameterNode* parameters,
                     vtkMRMLInnerGSModelNode* model) {
  vtkMRMLNode* selection = selectionOf(scene);
  if (!selection) return;
  refer(selection, kParameters, parameters);
  refer(selection, kModel, model);
}

vtkMRMLInnerGSParameterNode* chosenParameters(vtkMRMLScene* scene) {
  return referred<vtkMRMLInnerGSParameterNode>(selectionOf(scene), kParameters);
}

vtkMRMLInnerGSModelNode* chosenModel(vtkMRMLScene* scene) {
  return referred<vtkMRMLInnerGSModelNode>(selectionOf(scene), kModel);
}

void rememberShownModel(vtkMRMLSliceCompositeNode* view, vtkMRMLInnerGSModelNode* model,
                        vtkMRMLScalarVolumeNode* before) {
  refer(view, kModel, model);
  refer(view, kBackground, model ? before : nullptr);
}

vtkMRMLInnerGSModelNode* shownModel(vtkMRMLSliceCompositeNode* view) {
  return referred<vtkMRMLInnerGSModelNode>(view, kModel);
}

void restoreBackgrounds(vtkMRMLScene* scene) {
  std::vector<vtkMRMLNode*> nodes;
  if (scene) scene->GetNodesByClass("vtkMRMLSliceCompositeNode", nodes);
  for (vtkMRMLNode* node : nodes) {
    auto* view = vtkMRMLSliceCompositeNode::SafeDownCast(node);
    auto* before = referred<vtkMRMLScalarVolumeNode>(view, kBackground);
    const char* shown = view->GetBackgroundVolumeID();
    if (before && !(shown && scene->GetNodeByID(shown))) view->SetBackgroundVolumeID(before->GetID());
  }
}

} // namespace innergs::mrml
