#pragma once
#include "Widgets/Request.h"

#include <vtkMRMLScene.h>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLTableNode;
class vtkMRMLVolumeNode;
class vtkSlicerInnerGSJob;

/// Converts nodes and jobs for the panels.
namespace innergs::ui {

QString idOf(vtkMRMLNode* node); // "" for null
/// The scene's node of a class; null for another class, "" and a null scene.
template <class Node>
Node* nodeOf(vtkMRMLScene* scene, const QString& id) {
  return scene && !id.isEmpty() ? Node::SafeDownCast(scene->GetNodeByID(id.toUtf8().constData())) : nullptr;
}

VolumeInfo infoOf(vtkMRMLVolumeNode* node);
ModelInfo infoOf(vtkMRMLInnerGSModelNode* node);
Report reportOf(vtkSlicerInnerGSJob* job);
/// The rows of a job's table of scores, and which samples they are of; null: none.
QVector<QualityRow> qualityOf(vtkMRMLTableNode* table, QString& samples);

/// The ellipsoids of a model in the scene, and the first volume made from it; null if there is none.
vtkMRMLModelNode* ellipsoidsOf(vtkMRMLInnerGSModelNode* node);
vtkMRMLScalarVolumeNode* volumeOf(vtkMRMLInnerGSModelNode* node);
void setEllipsoidsOf(vtkMRMLInnerGSModelNode* model, vtkMRMLModelNode* ellipsoids);
/// Whether InnerGS made it, from a model or next to one.
bool isMade(vtkMRMLNode* node);
/// Whether a volume can be reconstructed from: it has voxels, is selectable, and was not made by InnerGS.
bool isScan(vtkMRMLNode* node);
/// Gives the node the model's provenance.
void setMadeFrom(vtkMRMLNode* node, vtkMRMLInnerGSModelNode* model);
/// Places it next to its sibling in the subject hierarchy.
void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling);

} // namespace innergs::ui
