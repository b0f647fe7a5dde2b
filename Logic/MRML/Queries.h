#pragma once
#include "Core/Image/GridGeometry.h"

#include <vtkSmartPointer.h>

class vtkFloatArray;
class vtkInnerGSAlgorithm;
class vtkInnerGSModel;
class vtkMatrix4x4;
class vtkMRMLInnerGSModelNode;
class vtkMRMLNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLVolumeNode;
class vtkPoints;

/// Queries of a model node, which its parent transform may have moved.
namespace innergs::mrml {

/// The model that a node holds. Throws Error(InvalidArgument) without node, Error(NoData) without Gaussians.
vtkInnerGSModel* modelOf(vtkMRMLInnerGSModelNode* node);

/// World → the model's own coordinates. Throws Error(Geometry) under an unusable transform.
void fromWorld(vtkMRMLInnerGSModelNode* node, vtkMatrix4x4* worldToNode);

/// Updates a filter; throws Error with its sentence when it fails.
void run(vtkInnerGSAlgorithm* filter);

/// The output, or a new volume node beside the model. Throws Error(InvalidArgument) without scene to add it
/// to.
vtkSmartPointer<vtkMRMLScalarVolumeNode> volumeFor(vtkMRMLScene* scene, vtkMRMLScalarVolumeNode* output,
                                                   vtkMRMLInnerGSModelNode* model, const char* suffix);

/// What the model was made from (attributes "InnerGS.…", the version at least) and a reference to it (role
/// "InnerGSModel") on a node made from the model.
void setProvenance(vtkMRMLNode* output, vtkMRMLInnerGSModelNode* model);

/// The logic's methods of these names; they change nothing when they throw Error.
void evaluate(vtkMRMLInnerGSModelNode* model, vtkPoints* points, vtkFloatArray* values);
vtkSmartPointer<vtkMRMLScalarVolumeNode> queryPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                    double spacing, vtkMRMLScalarVolumeNode* output);
vtkSmartPointer<vtkMRMLScalarVolumeNode> resample(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                  double spacing, vtkMRMLScalarVolumeNode* output);
vtkSmartPointer<vtkMRMLScalarVolumeNode> resampleLike(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                      vtkMRMLVolumeNode* reference,
                                                      vtkMRMLScalarVolumeNode* output);

} // namespace innergs::mrml
