#include "NodeInfo.h"
#include "qSlicerInnerGSHost.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLMarkupsDisplayNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSegmentation.h>

#include <initializer_list>

/// The host's part about nodes that come, go and change.

using namespace innergs::ui;

void qSlicerInnerGSHost::onScene(vtkObject*, unsigned long event, void* data) {
  if (event == vtkMRMLScene::NodeAboutToBeRemovedEvent) { // while its references are there
    auto* node = vtkMRMLInnerGSModelNode::SafeDownCast(static_cast<vtkMRMLNode*>(data));
    if (vtkMRMLModelNode* ellipsoids = node && !scene_->IsClosing() ? ellipsoidsOf(node) : nullptr)
      orphans_.push_back(ellipsoids);
    return;
  }
  changed_.start();
}

void qSlicerInnerGSHost::onModel(vtkObject* caller, unsigned long event, void*) {
  if (event == vtkMRMLTransformableNode::TransformModifiedEvent) {
    places_.remove(idOf(vtkMRMLNode::SafeDownCast(caller)));
    placeEllipsoids(vtkMRMLInnerGSModelNode::SafeDownCast(caller));
    if (!modelsMoved_.isActive()) modelsMoved_.start();
    return;
  }
  if (event == vtkMRMLInnerGSModelNode::ModelModifiedEvent)
    remade_.insert(idOf(vtkMRMLNode::SafeDownCast(caller)));
  if (!changed_.isActive()) changed_.start();
}

void qSlicerInnerGSHost::onVolume(vtkObject*, unsigned long, void*) {
  if (!volumesEdited_.isActive()) volumesEdited_.start();
}

void qSlicerInnerGSHost::watchVolumes() {
  volumeObservers_.clear();
  std::vector<vtkMRMLNode*> nodes;
  if (scene_ && active_) scene_->GetNodesByClass("vtkMRMLVolumeNode", nodes);
  for (vtkMRMLNode* node : nodes)
    for (const unsigned long event :
         {static_cast<unsigned long>(vtkCommand::ModifiedEvent),
          static_cast<unsigned long>(vtkMRMLVolumeNode::ImageDataModifiedEvent),
          static_cast<unsigned long>(vtkMRMLTransformableNode::TransformModifiedEvent)})
      volumeObservers_.add(node, event, this, &qSlicerInnerGSHost::onVolume);
}

/// What the panels know of the volumes, without their voxels.
QString qSlicerInnerGSHost::volumesNow() const {
  QString text;
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLVolumeNode", nodes);
  for (vtkMRMLNode* node : nodes) {
    auto* volume = vtkMRMLVolumeNode::SafeDownCast(node);
    if (volume->GetNodeReferenceID("InnerGSModel")) continue; // made here, some at each move of a view
    text += idOf(node) + QChar('\n') + QString::fromUtf8(node->GetName()) + QChar('\n') +
            QString::fromUtf8(volume->GetTransformNodeID());
    vtkNew<vtkMatrix4x4> matrix;
    volume->GetIJKToRASMatrix(matrix);
    vtkNew<vtkMatrix4x4> toWorld;
    if (vtkMRMLTransformNode* parent = volume->GetParentTransformNode()) {
      const bool linear = parent->IsTransformToWorldLinear();
      if (linear) parent->GetMatrixTransformToWorld(toWorld);
      text += QString::number(linear);
    }
    vtkMatrix4x4::Multiply4x4(toWorld, matrix, matrix);
    for (int i = 0; i < 16; ++i)
      text += QStringLiteral(" %1").arg(matrix->GetData()[i]);
    int size[3] = {0, 0, 0};
    if (volume->GetImageData()) volume->GetImageData()->GetDimensions(size);
    for (const int n : size)
      text += QStringLiteral(" %1").arg(n);
  }
  return text;
}

void qSlicerInnerGSHost::watchModels() {
  modelObservers_.clear();
  std::vector<vtkMRMLNode*> nodes;
  if (scene_) scene_->GetNodesByClass("vtkMRMLInnerGSModelNode", nodes);
  for (vtkMRMLNode* node : nodes)
    for (const unsigned long event :
         {static_cast<unsigned long>(vtkCommand::ModifiedEvent),
          static_cast<unsigned long>(vtkMRMLInnerGSModelNode::ModelModifiedEvent),
          static_cast<unsigned long>(vtkMRMLTransformableNode::TransformModifiedEvent)})
      modelObservers_.add(node, event, this, &qSlicerInnerGSHost::onModel);
  for (const QString& id : places_.keys())
    if (!modelNode(id)) places_.remove(id);
}

/// What else a request depends on than volumes: looked at only while the panels are.
void qSlicerInnerGSHost::watchChosen() {
  vtkMRMLInnerGSParameterNode* parameters = active_ ? parameters_.GetPointer() : nullptr;
  vtkMRMLNode* mask = parameters ? parameters->GetMaskNode() : nullptr;
  vtkMRMLNode* region = parameters ? parameters->GetROINode() : nullptr;
  if (parameters == watched_ && mask == watchedMask_ && region == watchedRegion_) return;
  watched_ = parameters;
  watchedMask_ = mask;
  watchedRegion_ = region;
  chosenEdited_.stop();
  chosenObservers_.clear();
  chosenObservers_.add(parameters, vtkCommand::ModifiedEvent, this, &qSlicerInnerGSHost::onParameters);
  const auto watch = [this](vtkMRMLNode* node, std::initializer_list<unsigned long> events) {
    for (const unsigned long event : events)
      chosenObservers_.add(node, event, this, &qSlicerInnerGSHost::onChosen);
  };
  watch(region, {vtkCommand::ModifiedEvent, vtkMRMLTransformableNode::TransformModifiedEvent,
                 vtkMRMLMarkupsNode::PointModifiedEvent});
  watch(mask, {vtkCommand::ModifiedEvent, vtkMRMLTransformableNode::TransformModifiedEvent});
  if (vtkMRMLSegmentationNode::SafeDownCast(mask)) // of any representation: painted
    watch(mask,
          {vtkMRMLSegmentationNode::SegmentationChangedEvent, vtkSegmentation::SegmentAdded,
           vtkSegmentation::SegmentRemoved, vtkSegmentation::SegmentModified,
           vtkSegmentation::RepresentationModified, vtkSegmentation::ContainedRepresentationNamesModified});
  else
    watch(mask, {vtkMRMLVolumeNode::ImageDataModifiedEvent});
}

void qSlicerInnerGSHost::onParameters(vtkObject*, unsigned long, void*) {
  watchChosen();
}

void qSlicerInnerGSHost::onChosen(vtkObject*, unsigned long, void*) {
  if (!chosenEdited_.isActive()) chosenEdited_.start();
}

/// A new region begins as the first input's box.
void qSlicerInnerGSHost::fitRegion(vtkMRMLNode* node) {
  auto* region = vtkMRMLMarkupsROINode::SafeDownCast(node);
  vtkMRMLVolumeNode* input = parameters_ ? parameters_->GetInputVolumeNode(0) : nullptr;
  if (!region || !input || !input->GetImageData()) return;
  double bounds[6];
  input->GetRASBounds(bounds);
  region->SetCenter((bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2, (bounds[4] + bounds[5]) / 2);
  region->SetSize(bounds[1] - bounds[0], bounds[3] - bounds[2], bounds[5] - bounds[4]);
  region->CreateDefaultDisplayNodes();
  if (auto* display =
          vtkMRMLMarkupsDisplayNode::SafeDownCast(region->GetDisplayNode())) { // not over the scan
    display->SetFillVisibility(false);
    display->SetOutlineVisibility(true);
  }
}

VolumeInfo qSlicerInnerGSHost::volumeInfo(const QString& id) const {
  auto* node =
      vtkMRMLVolumeNode::SafeDownCast(scene_ ? scene_->GetNodeByID(id.toUtf8().constData()) : nullptr);
  VolumeInfo info = infoOf(node);
  if (logic_ && info.sliceAxis == 2) info.sliceThickness = logic_->GetDicomSliceThickness(node);
  return info;
}
