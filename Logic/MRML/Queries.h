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

/// A node's model. Throws Error(InvalidArgument) without a node, Error(NoData) without Gaussians.
vtkInnerGSModel* modelOf(vtkMRMLInnerGSModelNode* node);

/// World → the model's own coordinates. Throws Error(Geometry) under an unusable transform.
void fromWorld(vtkMRMLInnerGSModelNode* node, vtkMatrix4x4* worldToNode);

/// Updates a filter; throws Error with its message if it fails.
void run(vtkInnerGSAlgorithm* filter);

/// The output, or a new volume node beside the model. Throws Error(InvalidArgument) without a scene to add it
/// to.
vtkSmartPointer<vtkMRMLScalarVolumeNode> volumeFor(vtkMRMLScene* scene, vtkMRMLScalarVolumeNode* output,
                                                   vtkMRMLInnerGSModelNode* model, const char* suffix);

/// Copies the model's provenance (attributes "InnerGS.…", at least the version) to a node made from it, with
/// a reference to the model (role "InnerGSModel").
void setProvenance(vtkMRMLNode* output, vtkMRMLInnerGSModelNode* model);

/// The standard deviation of the model's volume, which lies in the model's own coordinates; null: none. Its
/// image says what was measured (UncertaintyImage.h), in a scene that was loaded by the labelmap beside it.
vtkMRMLScalarVolumeNode* uncertaintyOf(vtkMRMLInnerGSModelNode* model);

/// The logic's methods of the same names; if they throw Error, nothing has changed.
void evaluate(vtkMRMLInnerGSModelNode* model, vtkPoints* points, vtkFloatArray* values);
vtkSmartPointer<vtkMRMLScalarVolumeNode> queryPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                    double spacing, vtkMRMLScalarVolumeNode* output);
/// The standard deviation of the model's volume there; throws Error(NoData) where it is not known.
vtkSmartPointer<vtkMRMLScalarVolumeNode>
queryUncertaintyPlane(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* planeToRAS,
                      int columns, int rows, double spacing, vtkMRMLScalarVolumeNode* output);
vtkSmartPointer<vtkMRMLScalarVolumeNode> resample(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                  double spacing, vtkMRMLScalarVolumeNode* output);
vtkSmartPointer<vtkMRMLScalarVolumeNode> resampleLike(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                      vtkMRMLVolumeNode* reference,
                                                      vtkMRMLScalarVolumeNode* output);

} // namespace innergs::mrml
