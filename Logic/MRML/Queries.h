#pragma once
#include "Core/GridGeometry.h"

class vtkInnerGSAlgorithm;
class vtkInnerGSModel;
class vtkMatrix4x4;
class vtkMRMLInnerGSModelNode;

/// Asking a model node, which its parent transform may have moved.
namespace innergs::mrml {

/// The model that a node holds. Throws Error(InvalidArgument) without node, Error(NoData) without Gaussians.
vtkInnerGSModel* modelOf(vtkMRMLInnerGSModelNode* node);

/// World → the model's own coordinates. Throws Error(Geometry) under an unusable transform.
void fromWorld(vtkMRMLInnerGSModelNode* node, vtkMatrix4x4* worldToNode);

/// Updates a filter; throws Error with its sentence when it fails.
void run(vtkInnerGSAlgorithm* filter);

} // namespace innergs::mrml
