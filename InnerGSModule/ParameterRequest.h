#pragma once
#include "Widgets/Request.h"

class vtkMRMLInnerGSParameterNode;

/// What the panels ask for and what the parameter node keeps with the scene: the same choices.
namespace innergs::ui {

Request requestOf(vtkMRMLInnerGSParameterNode* node);

/// Nodes that the scene does not have are left out; rows without a volume as well. The node is modified once,
/// and only when something differs.
void setRequest(vtkMRMLInnerGSParameterNode* node, const Request& request);

} // namespace innergs::ui
