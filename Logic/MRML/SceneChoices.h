#pragma once

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLSliceCompositeNode;

/// The choices of the panels and slice views, as references of nodes that every scene has, so that they are
/// saved with the scene. Null stands for nothing.
namespace innergs::mrml {

void rememberChoices(vtkMRMLScene* scene, vtkMRMLInnerGSParameterNode* parameters,
                     vtkMRMLInnerGSModelNode* model);
vtkMRMLInnerGSParameterNode* chosenParameters(vtkMRMLScene* scene);
vtkMRMLInnerGSModelNode* chosenModel(vtkMRMLScene* scene);

/// The model whose plane a slice view shows, and the background that it replaced.
void rememberShownModel(vtkMRMLSliceCompositeNode* view, vtkMRMLInnerGSModelNode* model,
                        vtkMRMLScalarVolumeNode* before);
vtkMRMLInnerGSModelNode* shownModel(vtkMRMLSliceCompositeNode* view);

/// Restores the backgrounds that the planes of shown models replaced, in a scene that was read: such planes
/// are not saved.
void restoreBackgrounds(vtkMRMLScene* scene);

} // namespace innergs::mrml
