#include "EllipsoidNodes.h"

#include "Core/Base/Failure.h"
#include "NodeInfo.h"
#include "Widgets/EllipsoidActor.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLModelDisplayNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLStorageNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkNew.h>
#include <vtkPolyData.h>

using namespace innergs::ui;

namespace {

vtkMRMLModelNode* addNode(vtkMRMLInnerGSModelNode* model) {
  vtkMRMLScene* scene = model->GetScene();
  const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + " Gaussians";
  auto* node = vtkMRMLModelNode::SafeDownCast(
      scene->AddNewNodeByClass("vtkMRMLModelNode", scene->GenerateUniqueName(name).c_str()));
  node->CreateDefaultDisplayNodes();
  placeBeside(node, model);
  return node;
}

} // namespace

void EllipsoidNodes::setMRMLScene(vtkMRMLScene* scene) {
  scene_ = scene;
}

void EllipsoidNodes::show(vtkMRMLInnerGSModelNode* model) {
  const QString id = idOf(model);
  pending_.insert(id);
  EllipsoidOptions options;
  options.most = 5000;
  options.window = infoOf(model).window;
  const auto core = model->GetModel()->GetCoreModel();
  run_([this, id, options, core]() -> std::function<void()> {
    QString problem;
    vtkNew<vtkInnerGSModel> copy; // the node's may be replaced
    copy->SetCoreModel(core);
    vtkSmartPointer<vtkPolyData> surfaces;
    const std::string thrown =
        innergs::sentenceOf([&] { surfaces = ellipsoidSurfaces(copy, options, &problem); });
    if (!thrown.empty()) problem = QString::fromStdString(thrown);
    return [this, id, options, core, problem, surfaces] {
      auto* now = nodeOf<vtkMRMLInnerGSModelNode>(scene_, id);
      if (!pending_.contains(id)) return;                                            // hidden in the meantime
      if (now && now->GetModel() && now->GetModel()->GetCoreModel() != core) return; // newer ones follow
      pending_.remove(id);
      if (!surfaces) Q_EMIT failed(problem);
      if (now && surfaces) showSurfaces(now, surfaces, options.window);
      Q_EMIT changed();
    };
  });
}

void EllipsoidNodes::hide(vtkMRMLInnerGSModelNode* model) {
  pending_.remove(idOf(model));
  if (vtkMRMLModelNode* ellipsoids = ellipsoidsOf(model)) ellipsoids->SetDisplayVisibility(0);
}

bool EllipsoidNodes::areShown(vtkMRMLInnerGSModelNode* model) const {
  vtkMRMLModelNode* ellipsoids = ellipsoidsOf(model);
  return arePending(idOf(model)) || (ellipsoids && ellipsoids->GetDisplayVisibility());
}

void EllipsoidNodes::showSurfaces(vtkMRMLInnerGSModelNode* model, vtkPolyData* surfaces,
                                  const std::array<double, 2>& window) {
  vtkMRMLModelNode* ellipsoids = ellipsoidsOf(model);
  if (!ellipsoids) ellipsoids = addNode(model);
  ellipsoids->SetAndObserveTransformNodeID(model->GetTransformNodeID());
  setMadeFrom(ellipsoids, model);
  setEllipsoidsOf(model, ellipsoids);
  ellipsoids->SetAndObservePolyData(surfaces);
  if (vtkMRMLModelDisplayNode* display = ellipsoids->GetModelDisplayNode()) {
    display->SetActiveScalarName("Intensity");
    display->SetAndObserveColorNodeID("vtkMRMLColorTableNodeGrey");
    display->SetScalarRangeFlag(vtkMRMLDisplayNode::UseManualScalarRange);
    display->SetScalarRange(window[0], window[1]);
    display->ScalarVisibilityOn();
  }
  ellipsoids->SetDisplayVisibility(1);
}

void EllipsoidNodes::place(vtkMRMLInnerGSModelNode* model) {
  if (!model || !scene_ || scene_->IsClosing() || scene_->IsImporting()) return;
  vtkMRMLModelNode* ellipsoids = ellipsoidsOf(model);
  if (ellipsoids && ellipsoids->GetParentTransformNode() != model->GetParentTransformNode())
    ellipsoids->SetAndObserveTransformNodeID(model->GetTransformNodeID());
}

void EllipsoidNodes::orphan(vtkMRMLInnerGSModelNode* model) {
  if (vtkMRMLModelNode* ellipsoids = ellipsoidsOf(model)) orphans_.push_back(ellipsoids);
}

void EllipsoidNodes::removeOrphans() {
  for (const vtkWeakPointer<vtkMRMLModelNode>& orphan : std::exchange(orphans_, {})) {
    if (!orphan || !scene_ || orphan->GetScene() != scene_) continue;
    const vtkSmartPointer<vtkMRMLNode> parts[] = {orphan->GetDisplayNode(), orphan->GetStorageNode()};
    scene_->RemoveNode(orphan);
    for (const vtkSmartPointer<vtkMRMLNode>& part : parts)
      if (part && part->GetScene() == scene_) scene_->RemoveNode(part);
  }
}
