#pragma once
#include "Core/Image/GridGeometry.h"

#include <string>

class vtkMRMLMarkupsROINode;
class vtkMRMLNode;
class vtkMRMLTransformableNode;
class vtkMRMLVolumeNode;
class vtkMatrix4x4;

/// Positions of nodes in the world (RAS mm), through their parent transforms.
namespace innergs::mrml {

/// The node's name; `otherwise` if it has none, or is null.
std::string nameOf(vtkMRMLNode* node, const std::string& otherwise = {});
/// 'name', for error messages.
std::string quoted(vtkMRMLNode* node);

/// Node coordinates → world. Throws Error(Geometry) under a transform that is not linear or not invertible.
void toWorld(vtkMRMLTransformableNode* node, vtkMatrix4x4* nodeToWorld);

/// Voxel indices → world; throws like toWorld.
void ijkToWorld(vtkMRMLVolumeNode* node, vtkMatrix4x4* ijkToWorld);

/// The LPS grid of a volume's voxels in the world. Throws Error(NoData) without image data, and like
/// toWorld.
GridGeometry gridOf(vtkMRMLVolumeNode* node);

/// An ROI as a grid of one voxel (LPS): its oriented box. Throws Error(Geometry) if it is empty or
/// sheared.
GridGeometry boxOf(vtkMRMLMarkupsROINode* roi);

/// sliceAxisOf() for a volume node's matrix.
int sliceAxis(vtkMatrix4x4* ijkToRAS);

} // namespace innergs::mrml
