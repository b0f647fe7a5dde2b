#include "qSlicerInnerGSViews.h"

#include "Cameras.h"
#include "NodeInfo.h"
#include "SceneChoices.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSelectionNode.h>
#include <vtkMRMLSliceCompositeNode.h>
#include <vtkMRMLSliceLogic.h>
#include <vtkMRMLSliceNode.h>
#include <vtkMRMLVolumePropertyNode.h>
#include <vtkMRMLVolumeRenderingDisplayNode.h>
#include <vtkSlicerApplicationLogic.h>
#include <vtkSlicerInnerGSLogic.h>
#include <vtkSlicerVolumeRenderingLogic.h>

#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace mrml = innergs::mrml;

namespace {

/// A volume only for a view: in no list, tree, save dialog or saved scene.
vtkSmartPointer<vtkMRMLScalarVolumeNode> addPicture(vtkMRMLInnerGSModelNode* model) {
  vtkNew<vtkMRMLScalarVolumeNode> node;
  const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + " slice";
  node->SetName(model->GetScene()->GenerateUniqueName(name).c_str());
  node->SetHideFromEditors(1);
  node->SetSelectable(0);
  node->SetSaveWithScene(0);
  node->UndoEnabledOff();
  model->GetScene()->AddNode(node);
  return node;
}

} // namespace

qSlicerInnerGSViews::qSlicerInnerGSViews(vtkSlicerInnerGSLogic* logic, vtkSlicerApplicationLogic* application,
                                         QObject* parent)
    : QObject(parent), logic_(logic), application_(application) {}

qSlicerInnerGSViews::~qSlicerInnerGSViews() {
  link(nullptr);
}

void qSlicerInnerGSViews::showInSlices(vtkMRMLScalarVolumeNode* volume) {
  vtkMRMLSelectionNode* selection = application_ ? application_->GetSelectionNode() : nullptr;
  if (!volume || !selection) return;
  selection->SetActiveVolumeID(volume->GetID());
  application_->PropagateBackgroundVolumeSelection(0);
}

bool qSlicerInnerGSViews::isShownIn3D(vtkMRMLScalarVolumeNode* volume) {
  for (int i = 0; volume && i < volume->GetNumberOfDisplayNodes(); ++i) {
    auto* display = vtkMRMLVolumeRenderingDisplayNode::SafeDownCast(volume->GetNthDisplayNode(i));
    if (display && display->GetVisibility()) return true;
  }
  return false;
}

QString qSlicerInnerGSViews::showIn3D(vtkMRMLScalarVolumeNode* volume, bool shown) {
  auto* rendering = vtkSlicerVolumeRenderingLogic::SafeDownCast(
      application_ ? application_->GetModuleLogic("VolumeRendering") : nullptr);
  if (!rendering) return tr("The module Volume Rendering is not loaded: enable it in Slicer's settings.");
  if (!volume) return tr("There is no result yet: reconstruct first.");
  vtkMRMLVolumeRenderingDisplayNode* display = rendering->GetFirstVolumeRenderingDisplayNode(volume);
  if (!display && shown) {
    display = rendering->CreateDefaultVolumeRenderingNodes(volume);
    if (!display) return tr("The volume cannot be rendered: show it with the module Volume Rendering.");
    // A preset for a known kind of scan, else the slice views' window.
    if (!rendering->SetRecommendedVolumeRenderingProperties(display))
      rendering->CopyDisplayToVolumeRenderingDisplayNode(display);
  }
  if (display) display->SetVisibility(shown);
  return {};
}

void qSlicerInnerGSViews::frameIn3D(vtkMRMLScalarVolumeNode* volume) {
  if (!volume || !volume->GetScene()) return;
  double bounds[6];
  volume->GetRASBounds(bounds);
  frameUntouchedCameras(volume->GetScene(), bounds);
}

//------------------------------------------------------------------------------ the linked view

vtkMRMLSliceCompositeNode* qSlicerInnerGSViews::layersOf(vtkMRMLSliceNode* slice) const {
  vtkMRMLSliceLogic* view = application_ && slice ? application_->GetSliceLogic(slice) : nullptr;
  return view ? view->GetSliceCompositeNode() : nullptr;
}

vtkMRMLSliceNode* qSlicerInnerGSViews::linked() const {
  return slice_;
}

void qSlicerInnerGSViews::link(vtkMRMLSliceNode* slice) {
  if (slice == slice_) return;
  showModel(nullptr);
  if (slice_) slice_->RemoveObserver(tag_);
  slice_ = slice;
  if (!slice) return;
  tag_ = slice->AddObserver(vtkCommand::ModifiedEvent, this, &qSlicerInnerGSViews::onSlice);
  Q_EMIT planeChanged(slice->GetSliceToRAS());
}

void qSlicerInnerGSViews::onSlice(vtkObject*, unsigned long, void*) {
  if (!moving_ && slice_) Q_EMIT planeChanged(slice_->GetSliceToRAS());
}

void qSlicerInnerGSViews::setPlane(vtkMatrix4x4* planeToRAS) {
  if (!slice_ || moving_) return;
  bool same = true;
  for (int i = 0; i < 16; ++i)
    same = same && std::abs(slice_->GetSliceToRAS()->GetData()[i] - planeToRAS->GetData()[i]) < 1e-6;
  if (same) return;
  moving_ = true;
  slice_->GetSliceToRAS()->DeepCopy(planeToRAS);
  slice_->UpdateMatrices();
  moving_ = false;
}

QString qSlicerInnerGSViews::showModel(vtkMRMLInnerGSModelNode* model) {
  vtkMRMLSliceCompositeNode* layers = layersOf(slice_);
  if (followed_) {
    if (logic_) logic_->StopFollowing(followed_);
    if (layers) mrml::rememberShownModel(layers, nullptr, nullptr);
    if (layers && followed_->GetID() && layers->GetBackgroundVolumeID() &&
        !strcmp(layers->GetBackgroundVolumeID(), followed_->GetID()))
      layers->SetBackgroundVolumeID(background_.isEmpty() ? nullptr : background_.toUtf8().constData());
    const vtkSmartPointer<vtkMRMLNode> display = followed_->GetDisplayNode();
    for (vtkMRMLNode* node : {static_cast<vtkMRMLNode*>(followed_), display.Get()})
      if (node && node->GetScene()) node->GetScene()->RemoveNode(node);
    followed_ = nullptr;
  }
  if (!model || !logic_) return {};
  if (!layers) return tr("Choose a slice view first.");
  const vtkSmartPointer<vtkMRMLScalarVolumeNode> picture = addPicture(model);
  followed_ = logic_->FollowSlice(model, slice_, picture);
  if (!followed_) {
    const QString problem = QString::fromStdString(logic_->GetLastError());
    if (picture->GetScene()) picture->GetScene()->RemoveNode(picture);
    return problem;
  }
  if (vtkMRMLNode* display = followed_->GetDisplayNode()) display->SetSaveWithScene(0);
  background_ = QString::fromUtf8(layers->GetBackgroundVolumeID());
  auto* before = innergs::ui::nodeOf<vtkMRMLScalarVolumeNode>(slice_->GetScene(), background_);
  vtkMRMLScalarVolumeDisplayNode* from = before ? before->GetScalarVolumeDisplayNode() : nullptr;
  vtkMRMLScalarVolumeDisplayNode* to = followed_->GetScalarVolumeDisplayNode();
  if (from && to) {
    to->SetAutoWindowLevel(0);
    to->SetWindowLevel(from->GetWindow(), from->GetLevel());
  }
  layers->SetBackgroundVolumeID(followed_->GetID());
  mrml::rememberShownModel(layers, model, before);
  return {};
}

vtkMRMLSliceNode* qSlicerInnerGSViews::remembered(vtkMRMLInnerGSModelNode** model) const {
  vtkMRMLScene* scene = logic_ ? logic_->GetMRMLScene() : nullptr;
  std::vector<vtkMRMLNode*> nodes;
  if (scene) scene->GetNodesByClass("vtkMRMLSliceNode", nodes);
  for (vtkMRMLNode* node : nodes) {
    auto* slice = vtkMRMLSliceNode::SafeDownCast(node);
    if ((*model = mrml::shownModel(layersOf(slice)))) return slice;
  }
  return nullptr;
}
