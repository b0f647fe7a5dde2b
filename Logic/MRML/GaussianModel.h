#pragma once
#include <vtkSmartPointer.h>

class vtkMRMLInnerGSModelNode;
class vtkMRMLModelNode;
class vtkMRMLScene;

namespace innergs::mrml {

/// At most `maximum` Gaussians (0: all) as points with tensors, in `output` or a new node beside the model,
/// for 3D views. Throws Error, and changes nothing then.
vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output);

} // namespace innergs::mrml
