#include "Queries.h"

#include "Core/Error.h"
#include "NodeGeometry.h"
#include "vtkInnerGSAlgorithm.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkCallbackCommand.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

namespace innergs::mrml {

vtkInnerGSModel* modelOf(vtkMRMLInnerGSModelNode* node) {
  if (!node) throw Error(ErrorCode::InvalidArgument, "There is no model: choose one.");
  if (node->IsEmpty())
    throw Error(ErrorCode::NoData, "The model " + quoted(node) + " is empty: reconstruct or load one first.");
  return node->GetModel();
}

void fromWorld(vtkMRMLInnerGSModelNode* node, vtkMatrix4x4* worldToNode) {
  toWorld(node, worldToNode);
  worldToNode->Invert();
}

void run(vtkInnerGSAlgorithm* filter) {
  vtkNew<vtkCallbackCommand> quiet; // the sentence goes up as an exception
  const unsigned long tag = filter->AddObserver(vtkCommand::ErrorEvent, quiet);
  filter->Update();
  filter->RemoveObserver(tag);
  if (const std::string message = filter->GetErrorMessage(); !message.empty())
    throw Error(ErrorCode::InvalidArgument, message);
}

} // namespace innergs::mrml
