#include "Core/Base/Error.h"
#include "NodeInfo.h"
#include "NodeTransform.h"
#include "qSlicerInnerGSHost.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLTransformNode.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <QDir>

/// The host's part about models and what is made of them.

using namespace innergs;
using namespace innergs::ui;

ModelInfo qSlicerInnerGSHost::modelInfo(const QString& id) const {
  ModelInfo info = infoOf(modelNode(id));
  info.ellipsoidsShown = info.ellipsoidsShown || ellipsoidsWanted_.contains(id);
  return info;
}

vtkInnerGSModel* qSlicerInnerGSHost::model(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node && !node->IsEmpty() && placeOf(node).problem.isEmpty() ? node->GetModel() : nullptr;
}

vtkSmartPointer<vtkAbstractTransform> qSlicerInnerGSHost::toModel(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node ? placeOf(node).toModel : nullptr;
}

QString qSlicerInnerGSHost::modelProblem(const QString& id) const {
  vtkMRMLInnerGSModelNode* node = modelNode(id);
  return node && !node->IsEmpty() ? placeOf(node).problem : QString();
}

const qSlicerInnerGSHost::Place& qSlicerInnerGSHost::placeOf(vtkMRMLInnerGSModelNode* node) const {
  vtkMRMLTransformNode* parent = node->GetParentTransformNode();
  const vtkMTimeType changed = parent ? parent->GetTransformToWorldMTime() : 0;
  const auto found = places_.constFind(idOf(node));
  if (found != places_.constEnd() && found->parent == parent && found->changed == changed) return *found;
  Place place{parent, changed, nullptr, {}};
  try {
    place.toModel = mrml::transformFromWorld(node);
  } catch (const Error& error) {
    place.problem = QString::fromStdString(error.what());
  }
  return *places_.insert(idOf(node), place);
}

QString qSlicerInnerGSHost::loadModel(const QString& file, QString* error) {
  vtkMRMLNode* node = nullptr;
  if (logic_) {
    const auto read = logic_->LoadModelLater(QDir::toNativeSeparators(file).toStdString());
    std::function<vtkMRMLInnerGSModelNode*()> make;
    const QString problem = runAndWait([&] { make = read(); });
    if (!problem.isEmpty()) {
      if (error) *error = problem;
      return {};
    }
    node = make();
  }
  if (!node && error) *error = lastError();
  if (node) Q_EMIT logged(tr("Loaded %1").arg(file));
  return idOf(node);
}

QString qSlicerInnerGSHost::saveModel(const QString& id, const QString& file) {
  if (!logic_) return lastError();
  const auto write = logic_->SaveModelLater(modelNode(id), QDir::toNativeSeparators(file).toStdString());
  std::function<bool()> note;
  const QString problem = runAndWait([&] { note = write(); });
  if (!problem.isEmpty()) return problem;
  if (!note()) return lastError();
  Q_EMIT logged(tr("Saved %1").arg(file));
  Q_EMIT modelsChanged();
  return {};
}

QString qSlicerInnerGSHost::addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                                      QString* error) {
  if (!scene_ || !image) {
    if (error) *error = tr("There is no scene to add a volume to.");
    return {};
  }
  auto* node = vtkMRMLScalarVolumeNode::SafeDownCast(scene_->AddNewNodeByClass(
      "vtkMRMLScalarVolumeNode", scene_->GenerateUniqueName(name.toStdString()).c_str()));
  vtkNew<vtkImageData> own; // a volume node's geometry is in its matrix alone
  own->DeepCopy(image);
  own->SetOrigin(0, 0, 0);
  own->SetSpacing(1, 1, 1);
  own->GetDirectionMatrix()->Identity();
  node->SetAndObserveImageData(own);
  node->SetIJKToRASMatrix(ijkToRAS);
  node->CreateDefaultDisplayNodes();
  return idOf(node);
}

QString qSlicerInnerGSHost::addVolumeOf(const QString& modelId, const std::array<double, 2>& window,
                                        vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                                        QString* error) {
  const QString id = addVolume(image, ijkToRAS, name, error);
  auto* volume = vtkMRMLScalarVolumeNode::SafeDownCast(
      id.isEmpty() ? nullptr : scene_->GetNodeByID(id.toUtf8().constData()));
  if (!volume) return id;
  if (vtkMRMLScalarVolumeDisplayNode* display = volume->GetScalarVolumeDisplayNode()) {
    display->SetAutoWindowLevel(0);
    display->SetWindowLevelMinMax(window[0], window[1]);
  }
  if (vtkMRMLInnerGSModelNode* from = modelNode(modelId)) {
    setMadeFrom(volume, from);
    placeBeside(volume, from);
  }
  return id;
}
