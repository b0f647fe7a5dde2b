#pragma once

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLSliceCompositeNode;

/// What was chosen in the panels and shown in the slice views, as references of nodes that every scene has,
/// so that a saved scene knows it. Null stands for nothing.
namespace innergs::mrml {

void rememberChoices(vtkMRMLScene* scene, vtkMRMLInnerGSParameterNode* parameters,
                     vtkMRMLInnerGSModelNode* model);
vtkMRMLInnerGSParameterNode* chosenParameters(vtkMRMLScene* scene);
vtkMRMLInnerGSModelNode* chosenModel(vtkMRMLScene* scene);

/// The model whose plane a slice view shows, and the background that it took the place of.
void rememberShownModel(vtkMRMLSliceCompositeNode* view, vtkMRMLInnerGSModelNode* model,
                        vtkMRMLScalarVolumeNode* before);
vtkMRMLInnerGSModelNode* shownModel(vtkMRMLSliceCompositeNode* view);

/// Puts back what the shown models' planes, which are not saved, took the place of: for a scene that was
/// read.
void restoreBackgrounds(vtkMRMLScene* scene);

} // namespace innergs::mrml
