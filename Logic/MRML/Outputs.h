#pragma once
#include "JobSetup.h"

class vtkImageData;
class vtkMRMLLabelMapVolumeNode;
class vtkMatrix4x4;
class vtkMRMLNode;

namespace innergs::mrml {

/// Turns a finished task into nodes: the chosen outputs or new ones, in world coordinates (no parent
/// transform), with their provenance as attributes. Replaces a chosen node that was deleted in the meantime
/// by a new one; skips what an observer removes during creation.
/// Ends early if an observer discards the task. Does not throw.
struct Outputs {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> volume;
  vtkSmartPointer<vtkMRMLInnerGSModelNode> model;
  vtkSmartPointer<vtkMRMLTableNode> table;
  vtkSmartPointer<vtkMRMLTableNode> slices;             // null where slices were not moved
  vtkSmartPointer<vtkMRMLScalarVolumeNode> uncertainty; // null where it was not asked for or is not known
  vtkSmartPointer<vtkMRMLLabelMapVolumeNode> measured;  // likewise: 1 where some slice measured the tissue
  bool replaced = false;                                // a chosen node was deleted
  std::string problem;                                  // a sentence on what failed; everything else is done
};
Outputs makeOutputs(const Task& task, vtkMRMLScene* scene);

/// A new node of a class with a unique name; an observer may already have removed it from the scene.
vtkSmartPointer<vtkMRMLNode> addNode(vtkMRMLScene* scene, const char* className, const std::string& name);

/// Puts image and geometry into a volume node, in world coordinates; keeps the display or makes one like
/// `like`'s.
void setVolume(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
               vtkMRMLVolumeNode* like = nullptr);

/// Puts standard deviations into a volume node likewise, with a colour map from 0 to what few voxels exceed;
/// their units are those of `like`.
void setDeviation(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
                  vtkMRMLVolumeNode* like = nullptr);

/// The role in which a model refers to the standard deviation of its volume, and that to where it was
/// measured.
constexpr const char* kUncertaintyRole = "InnerGSUncertainty";
constexpr const char* kMeasuredRole = "InnerGSMeasured";

/// Places a node beside another one in the subject hierarchy, if there is one.
void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling);
/// Removes an output that left the scene from the subject hierarchy: only the application's plugins do that,
/// and a dead item would be mistaken for the next node with the same address.
void leaveHierarchy(vtkMRMLNode* node, vtkMRMLScene* scene);

} // namespace innergs::mrml
