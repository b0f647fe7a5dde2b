#pragma once
#include "Widgets/Request.h"

#include <vector>

class vtkMRMLInnerGSParameterNode;
class vtkMRMLNode;

/// Converts between the panels' request and the parameter node, which the scene saves.
namespace innergs::ui {

Request requestOf(vtkMRMLInnerGSParameterNode* node);
/// The mask for all inputs and their own, as far as they are in the scene.
std::vector<vtkMRMLNode*> masksOf(vtkMRMLInnerGSParameterNode* node);

/// Skips nodes that are not in the scene, and rows without a volume. Modifies the node once, and only if
/// something differs.
void setRequest(vtkMRMLInnerGSParameterNode* node, const Request& request);

} // namespace innergs::ui
