#pragma once
#include <vtkSmartPointer.h>

#include <string>

class vtkMRMLInnerGSModelNode;
class vtkMRMLModelNode;
class vtkMRMLScene;

/// Model nodes from and to files, and their Gaussians as nodes for 3D views. All throw Error and then change
/// nothing.
namespace innergs::mrml {

/// A new node with its storage node from an .innergs or .ply file.
vtkMRMLInnerGSModelNode* loadModel(vtkMRMLScene* scene, const std::string& fileName);
/// A model file (.innergs) becomes the node's own, in its storage node; a PLY file is an export.
void saveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName);

/// At most so many Gaussians (0: all) as points with tensors, in `output` or a new node beside the model.
vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output);

} // namespace innergs::mrml
