#include "qSlicerInnerGSHost.h"

#include <vtkMRMLDisplayNode.h>
#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkSegmentation.h>

// The scene's segments by what they are called.

using innergs::MadeSegments;
using innergs::NamedLabels;

std::function<NamedLabels(const std::stop_token&)> qSlicerInnerGSHost::labelsFor(const QString& modelId,
                                                                                 const QString& labelsId,
                                                                                 const QString&,
                                                                                 QString* error) {
  vtkMRMLNode* labels = scene_ ? scene_->GetNodeByID(labelsId.toUtf8().constData()) : nullptr;
  std::function<NamedLabels(const std::stop_token&)> later;
  if (logic_) later = logic_->LabelsLater(modelNode(modelId), labels);
  if (!later) *error = lastError();
  return later;
}

QString qSlicerInnerGSHost::setFeatures(const QString& modelId,
                                        const std::shared_ptr<const innergs::FeatureModel>& features) {
  vtkMRMLInnerGSModelNode* node = modelNode(modelId);
  if (!node || node->IsEmpty()) return tr("The model is no longer in the scene.");
  node->SetFeatures(features);
  Q_EMIT modelsChanged();
  return {};
}

void qSlicerInnerGSHost::previewSegments(const QString& modelId, const MadeSegments& made) {
  if (!logic_ || !scene_ || scene_->IsClosing()) return;
  if (preview_ &&
      (made.segments.empty() || preview_->GetNodeReference("InnerGSModel") != modelNode(modelId))) {
    scene_->RemoveNode(preview_);
    preview_ = nullptr;
  }
  if (made.segments.empty()) return;
  if (preview_) preview_->GetSegmentation()->RemoveAllSegments();
  preview_ = logic_->AddSegments(modelNode(modelId), made, preview_);
  if (!preview_) return;
  preview_->SetName(tr("Found").toUtf8().constData());
  preview_->SetSaveWithScene(false);
  if (vtkMRMLNode* display = preview_->GetDisplayNode()) display->SetSaveWithScene(false);
}

QString qSlicerInnerGSHost::addSegments(const QString& modelId, const MadeSegments& made, QString* error) {
  vtkMRMLSegmentationNode* kept = logic_ ? logic_->AddSegments(modelNode(modelId), made) : nullptr;
  if (!kept) {
    *error = lastError();
    return {};
  }
  previewSegments(modelId, {}); // it would lie over what is kept
  return QString::fromUtf8(kept->GetName());
}
