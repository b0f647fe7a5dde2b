#include "NodeInfo.h"
#include "Widgets/EllipsoidActor.h"
#include "qSlicerInnerGSHost.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLModelDisplayNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkPolyData.h>

/// The Gaussians as surfaces in a model node beside the model: a few thousand, or 3D views would stall.
QString qSlicerInnerGSHost::showEllipsoids(const QString& id, bool shown) {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  if (!node || !logic_) return tr("There is no model: choose one.");
  vtkMRMLModelNode* ellipsoids = innergs::ui::ellipsoidsOf(node);
  if (shown) {
    innergs::ui::EllipsoidOptions options;
    options.most = 5000;
    options.window = innergs::ui::infoOf(node).window;
    QString problem;
    const auto surfaces = innergs::ui::ellipsoidSurfaces(node->GetModel(), options, &problem);
    if (!surfaces) return problem;
    ellipsoids = logic_->CreateGaussianModel(node, 1, ellipsoids); // the node and its place
    if (!ellipsoids) return lastError();
    ellipsoids->SetAndObservePolyData(surfaces);
    if (vtkMRMLModelDisplayNode* display = ellipsoids->GetModelDisplayNode()) {
      display->SetActiveScalarName("Intensity");
      display->SetAndObserveColorNodeID("vtkMRMLColorTableNodeGrey");
      display->SetScalarRangeFlag(vtkMRMLDisplayNode::UseManualScalarRange);
      display->SetScalarRange(options.window[0], options.window[1]);
      display->ScalarVisibilityOn();
    }
  }
  if (ellipsoids) ellipsoids->SetDisplayVisibility(shown);
  Q_EMIT modelsChanged();
  return {};
}
