#include "GaussianModel.h"

#include "Core/Base/Error.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "Queries.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSToPolyData.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLScene.h>

#include <vtkNew.h>
#include <vtkPolyData.h>

namespace innergs::mrml {

vtkSmartPointer<vtkMRMLModelNode> makeGaussianModel(vtkMRMLScene* scene, vtkMRMLInnerGSModelNode* model,
                                                    int maximum, vtkMRMLModelNode* output) {
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> kept = model; // an observer may remove it
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(model));
  filter->SetMaximumNumberOfGaussians(maximum);
  run(filter);
  // Observers of the following may remove the node.
  vtkSmartPointer<vtkMRMLModelNode> made = output;
  if (!made) {
    if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a model to: set one.");
    const std::string name = nameOf(model, "Model") + " Gaussians";
    made = vtkMRMLModelNode::SafeDownCast(addNode(scene, "vtkMRMLModelNode", name));
    if (made->GetScene()) made->CreateDefaultDisplayNodes();
    placeBeside(made, model);
  }
  made->SetAndObserveTransformNodeID(model->GetTransformNodeID());
  vtkNew<vtkPolyData> own;
  own->ShallowCopy(filter->GetOutput());
  setProvenance(made, model);
  made->SetAndObservePolyData(own);
  return made;
}

} // namespace innergs::mrml
