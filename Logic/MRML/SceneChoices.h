#pragma once

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLSliceCompositeNode;

/// The choices of the panels and slice views, stored as references of nodes that every scene has, so that
/// they are saved with the scene. Null means none.
namespace innergs::mrml {

void rememberChoices(vtkMRMLScene* scene, vtkMRMLInnerGSParameterNode* parameters,
                     vtkMRMLInnerGSModelNode* model);
vtkMRMLInnerGSParameterNode* chosenParameters(vtkMRMLScene* scene);
vtkMRMLInnerGSModelNode* chosenModel(vtkMRMLScene* scene);

/// The model whose plane a slice view shows, and the background that it replaced.
void rememberShownModel(vtkMRMLSliceCompositeNode* view, vtkMRMLInnerGSModelNode* model,
                        vtkMRMLScalarVolumeNode* before);
vtkMRMLInnerGSModelNode* shownModel(vtkMRMLSliceCompositeNode* view);

/// After a scene was read, restores the backgrounds that the planes of shown models replaced, since such
/// planes are not saved.
void restoreBackgrounds(vtkMRMLScene* scene);

} // namespace innergs::mrml
