#include "VolumeObserver.h"

#include "NodeInfo.h"

#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkCommand.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <utility>
#include <vector>

using innergs::ui::idOf;

VolumeObserver::VolumeObserver(QObject* parent) : QObject(parent) {
  timer_.setSingleShot(true);
  timer_.setInterval(150);
  connect(&timer_, &QTimer::timeout, this, [this] {
    const QString now = text();
    if (now == std::exchange(before_, now)) return;
    Q_EMIT edited();
  });
}

void VolumeObserver::setMRMLScene(vtkMRMLScene* scene) {
  observers_.clear();
  scene_ = scene;
}

void VolumeObserver::setActive(bool active) {
  active_ = active;
  observe();
}

void VolumeObserver::update() {
  observe();
  before_ = text();
}

void VolumeObserver::onVolume(vtkObject*, unsigned long, void*) {
  if (!timer_.isActive()) timer_.start();
}

void VolumeObserver::observe() {
  observers_.clear();
  std::vector<vtkMRMLNode*> nodes;
  if (scene_ && active_) scene_->GetNodesByClass("vtkMRMLVolumeNode", nodes);
  for (vtkMRMLNode* node : nodes)
    observers_.add(node,
                   {vtkCommand::ModifiedEvent, vtkMRMLVolumeNode::ImageDataModifiedEvent,
                    vtkMRMLTransformableNode::TransformModifiedEvent},
                   this, &VolumeObserver::onVolume);
}

/// What the panels show of the volumes, without their voxels.
QString VolumeObserver::text() const {
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
