#pragma once
#include "JobSetup.h"

class vtkImageData;
class vtkMatrix4x4;
class vtkMRMLNode;

namespace innergs::mrml {

/// Turns a finished task into nodes: the chosen outputs or new ones, placed in the world (no parent
/// transform), with what they were made from as attributes. A chosen node deleted in the meantime is replaced
/// by a new one; what an observer removes as it is made is left out.
/// Ends early when an observer discards the task. Does not throw.
struct Outputs {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> volume;
  vtkSmartPointer<vtkMRMLInnerGSModelNode> model;
  vtkSmartPointer<vtkMRMLTableNode> table;
  bool replaced = false; // a chosen node was gone
  std::string problem;   // what could not be done, a sentence; the rest is made all the same
};
Outputs makeOutputs(const Task& task, vtkMRMLScene* scene);

/// A new node of a class under a unique name; an observer may have removed it from the scene again.
vtkSmartPointer<vtkMRMLNode> addNode(vtkMRMLScene* scene, const char* className, const std::string& name);

/// Image and geometry into a volume node, in the world; the display is kept, or made like `like`'s.
void setVolume(vtkMRMLScalarVolumeNode* node, vtkImageData* image, vtkMatrix4x4* ijkToRAS,
               vtkMRMLVolumeNode* like = nullptr);

/// Beside another node in the subject hierarchy, if there is one.
void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling);
/// Takes an output that was removed from the scene out of the subject hierarchy: only the application's
/// plugins do that, and a dead item is mistaken for the next node with the same address.
void leaveHierarchy(vtkMRMLNode* node, vtkMRMLScene* scene);

} // namespace innergs::mrml
