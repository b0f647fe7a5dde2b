#include "NodeInfo.h"
#include "qSlicerInnerGSHost.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLModelDisplayNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkSphereSource.h>
#include <vtkTensorGlyph.h>

/// The Gaussians as a model node of ellipsoids; a few thousand, evenly picked, or 3D views would stall.
QString qSlicerInnerGSHost::showEllipsoids(const QString& id, bool shown) {
  constexpr int kMaximum = 4000;
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  if (!node || !logic_) return tr("There is no model: choose one.");
  vtkMRMLModelNode* ellipsoids = innergs::ui::ellipsoidsOf(node);
  if (shown) {
    ellipsoids = logic_->CreateGaussianModel(node, kMaximum, ellipsoids);
    if (!ellipsoids) return lastError();
    vtkNew<vtkSphereSource> sphere;
    sphere->SetRadius(1);
    sphere->SetThetaResolution(10);
    sphere->SetPhiResolution(8);
    vtkNew<vtkTensorGlyph> glyph;
    glyph->SetInputData(ellipsoids->GetPolyData());
    glyph->SetSourceConnection(sphere->GetOutputPort());
    glyph->ColorGlyphsOn();
    glyph->SetColorModeToScalars();
    glyph->Update();
    ellipsoids->SetAndObservePolyData(glyph->GetOutput());
    if (vtkMRMLModelDisplayNode* display = ellipsoids->GetModelDisplayNode()) {
      const auto window = innergs::ui::infoOf(node).window;
      vtkPolyData* mesh = ellipsoids->GetPolyData();
      if (mesh->GetPointData()->GetScalars() && mesh->GetPointData()->GetScalars()->GetName())
        display->SetActiveScalarName(mesh->GetPointData()->GetScalars()->GetName());
      display->SetAndObserveColorNodeID("vtkMRMLColorTableNodeGrey");
      display->SetScalarRangeFlag(vtkMRMLDisplayNode::UseManualScalarRange);
      display->SetScalarRange(window[0], window[1]);
      display->ScalarVisibilityOn();
    }
  }
  if (ellipsoids) ellipsoids->SetDisplayVisibility(shown);
  Q_EMIT modelsChanged();
  return {};
}
