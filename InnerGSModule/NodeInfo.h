#pragma once
#include "Widgets/Request.h"

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLVolumeNode;
class vtkSlicerInnerGSJob;

/// Nodes and jobs as the panels see them.
namespace innergs::ui {

QString idOf(vtkMRMLNode* node); // "" for null

VolumeInfo infoOf(vtkMRMLVolumeNode* node);
ModelInfo infoOf(vtkMRMLInnerGSModelNode* node);
Report reportOf(vtkSlicerInnerGSJob* job);

/// The ellipsoids of a model in the scene, and the first volume made from it; null when there is none.
vtkMRMLModelNode* ellipsoidsOf(vtkMRMLInnerGSModelNode* node);
vtkMRMLScalarVolumeNode* volumeOf(vtkMRMLInnerGSModelNode* node);
void setEllipsoidsOf(vtkMRMLInnerGSModelNode* model, vtkMRMLModelNode* ellipsoids);
/// Whether InnerGS made it, from a model or beside one.
bool isMade(vtkMRMLNode* node);
/// Whether a volume is one to reconstruct: it has voxels, people can choose it, and InnerGS did not make it.
bool isScan(vtkMRMLNode* node);
/// Gives the node the model's provenance.
void setMadeFrom(vtkMRMLNode* node, vtkMRMLInnerGSModelNode* model);
/// In the subject hierarchy.
void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling);

} // namespace innergs::ui
