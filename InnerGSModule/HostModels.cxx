#include "Core/Error.h"
#include "NodeGeometry.h"
#include "NodeInfo.h"
#include "qSlicerInnerGSHost.h"
#include "vtkInnerGSModel.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkCallbackCommand.h>
#include <vtkImageData.h>
#include <vtkMatrix3x3.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <QDir>

#include <algorithm>

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
  if (!node || node->IsEmpty()) return nullptr;
  vtkNew<vtkMatrix4x4> toWorld;
  QString problem;
  try {
    mrml::toWorld(node, toWorld);
  } catch (const Error& error) {
    problem = QString::fromStdString(error.what());
    toWorld->Zero();
  }
  if (toWorld->IsIdentity()) {
    moved_.remove(id);
    return node->GetModel();
  }
  std::array<double, 16> matrix;
  std::copy_n(toWorld->GetData(), 16, matrix.begin());
  Moved& moved = moved_[id];
  if (!moved.node || moved.from != node->GetModel() || moved.matrix != matrix) {
    moved = {vtkSmartPointer<vtkMRMLInnerGSModelNode>::New(), node->GetModel(), matrix, problem};
    if (problem.isEmpty()) {
      vtkNew<vtkCallbackCommand> quiet; // the sentence is for the panel
      moved.node->AddObserver(vtkCommand::ErrorEvent, quiet);
      moved.node->SetModel(node->GetModel());
      moved.node->ApplyTransformMatrix(toWorld);
      if (moved.node->GetModel()->GetCheckpoint() == node->GetModel()->GetCheckpoint())
        moved.problem =
            tr("'%1' is under a transform that shears it, which its planes cannot follow: correct or "
               "remove the transform.")
                .arg(QString::fromUtf8(node->GetName()));
    }
  }
  return moved.problem.isEmpty() ? moved.node->GetModel() : nullptr;
}

QString qSlicerInnerGSHost::modelProblem(const QString& id) const {
  return model(id) ? QString() : moved_.value(id).problem;
}

QString qSlicerInnerGSHost::loadModel(const QString& file, QString* error) {
  vtkMRMLNode* node = logic_ ? logic_->LoadModel(QDir::toNativeSeparators(file).toStdString()) : nullptr;
  if (!node && error) *error = lastError();
  if (node) Q_EMIT logged(tr("Loaded %1").arg(file));
  return idOf(node);
}

QString qSlicerInnerGSHost::saveModel(const QString& id, const QString& file) {
  if (!logic_ || !logic_->SaveModel(modelNode(id), QDir::toNativeSeparators(file).toStdString()))
    return lastError();
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
