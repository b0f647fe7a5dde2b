#include "Core/Base/Failure.h"
#include "NodeInfo.h"
#include "Widgets/EllipsoidActor.h"
#include "qSlicerInnerGSHost.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLModelDisplayNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLStorageNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkNew.h>
#include <vtkPolyData.h>

#include <utility>

namespace {

/// A model node beside the model that refers to it.
vtkMRMLModelNode* addEllipsoids(vtkMRMLInnerGSModelNode* model) {
  vtkMRMLScene* scene = model->GetScene();
  const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + " Gaussians";
  auto* node = vtkMRMLModelNode::SafeDownCast(
      scene->AddNewNodeByClass("vtkMRMLModelNode", scene->GenerateUniqueName(name).c_str()));
  node->CreateDefaultDisplayNodes();
  innergs::ui::placeBeside(node, model);
  return node;
}

} // namespace

/// The Gaussians as surfaces in a model node beside the model: a few thousand, or 3D views would stall.
QString qSlicerInnerGSHost::showEllipsoids(const QString& id, bool shown) {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  if (!node || node->IsEmpty()) return tr("There is no model: choose one.");
  if (shown) {
    findEllipsoids(node);
  } else {
    ellipsoidsWanted_.remove(id);
    if (vtkMRMLModelNode* ellipsoids = innergs::ui::ellipsoidsOf(node)) ellipsoids->SetDisplayVisibility(0);
  }
  Q_EMIT modelsChanged();
  return {};
}

void qSlicerInnerGSHost::findEllipsoids(vtkMRMLInnerGSModelNode* node) {
  const QString id = innergs::ui::idOf(node);
  ellipsoidsWanted_.insert(id);
  innergs::ui::EllipsoidOptions options;
  options.most = 5000;
  options.window = innergs::ui::infoOf(node).window;
  const auto checkpoint = node->GetModel()->GetCheckpoint();
  run([this, id, options, checkpoint]() -> std::function<void()> {
    QString problem;
    vtkNew<vtkInnerGSModel> model; // the node's may become another
    model->SetCheckpoint(checkpoint);
    vtkSmartPointer<vtkPolyData> surfaces;
    const std::string thrown =
        innergs::sentenceOf([&] { surfaces = innergs::ui::ellipsoidSurfaces(model, options, &problem); });
    if (!thrown.empty()) problem = QString::fromStdString(thrown);
    return [this, id, options, checkpoint, problem, surfaces] {
      vtkMRMLInnerGSModelNode* now = modelNode(id);
      if (!ellipsoidsWanted_.contains(id)) return;                                          // hidden again
      if (now && now->GetModel() && now->GetModel()->GetCheckpoint() != checkpoint) return; // others follow
      ellipsoidsWanted_.remove(id);
      if (!surfaces) Q_EMIT logged(problem);
      if (now && surfaces) showSurfaces(id, surfaces, options.window);
      Q_EMIT modelsChanged();
    };
  });
}

void qSlicerInnerGSHost::showSurfaces(const QString& id, vtkPolyData* surfaces,
                                      const std::array<double, 2>& window) {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  vtkMRMLModelNode* ellipsoids = innergs::ui::ellipsoidsOf(node);
  if (!ellipsoids) ellipsoids = addEllipsoids(node);
  ellipsoids->SetAndObserveTransformNodeID(node->GetTransformNodeID());
  innergs::ui::setMadeFrom(ellipsoids, node);
  innergs::ui::setEllipsoidsOf(node, ellipsoids);
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

/// They lie where the model does.
void qSlicerInnerGSHost::placeEllipsoids(vtkMRMLInnerGSModelNode* node) {
  if (!node || !scene_ || scene_->IsClosing() || scene_->IsImporting()) return;
  vtkMRMLModelNode* ellipsoids = innergs::ui::ellipsoidsOf(node);
  if (ellipsoids && ellipsoids->GetParentTransformNode() != node->GetParentTransformNode())
    ellipsoids->SetAndObserveTransformNodeID(node->GetTransformNodeID());
}

/// Those of models that were removed go with them: no panel could hide them.
void qSlicerInnerGSHost::removeOrphans() {
  for (const vtkWeakPointer<vtkMRMLModelNode>& orphan : std::exchange(orphans_, {})) {
    if (!orphan || !scene_ || orphan->GetScene() != scene_) continue;
    const vtkSmartPointer<vtkMRMLNode> parts[] = {orphan->GetDisplayNode(), orphan->GetStorageNode()};
    scene_->RemoveNode(orphan);
    for (const vtkSmartPointer<vtkMRMLNode>& part : parts)
      if (part && part->GetScene() == scene_) scene_->RemoveNode(part);
  }
}
