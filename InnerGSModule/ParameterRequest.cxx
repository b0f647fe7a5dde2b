#include "ParameterRequest.h"

#include "NodeInfo.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScalarVolumeNode.h>

namespace innergs::ui {
namespace {

QStringList masksOf(const Request& request) {
  QStringList masks{request.maskId};
  for (const InputChoice& input : request.inputs)
    if (!input.maskId.isEmpty()) masks << input.maskId;
  return masks;
}

} // namespace

Request requestOf(vtkMRMLInnerGSParameterNode* node) {
  Request request;
  for (int i = 0; i < node->GetNumberOfInputVolumeNodes(); ++i)
    if (vtkMRMLVolumeNode* input = node->GetInputVolumeNode(i))
      request.inputs.append({idOf(input), node->GetInputSliceThickness(input),
                             node->GetInputSliceProfile(input), node->GetInputSliceAxis(input),
                             idOf(node->GetInputMaskNode(input)), idOf(node->GetInputSlicePosesNode(input))});
  request.maskId = idOf(node->GetMaskNode());
  request.regionId = idOf(node->GetROINode());
  request.grid = static_cast<OutputGrid>(node->GetOutputGrid());
  request.spacing = node->GetOutputSpacing();
  request.referenceId = idOf(node->GetReferenceVolumeNode());
  request.outputVolumeId = idOf(node->GetOutputVolumeNode());
  request.outputModelId = idOf(node->GetOutputModelNode());
  request.settings = node->GetSettings();
  request.heldOutFraction = node->GetHeldOutFraction();
  request.resumeFile = QString::fromStdString(node->GetResumeFileName());
  request.estimateUncertainty = node->GetEstimateUncertainty();
  request.evaluateQuality = node->GetEvaluateQuality();
  request.qualityGap = node->GetQualityGap();
  return request;
}

std::vector<vtkMRMLNode*> masksOf(vtkMRMLInnerGSParameterNode* node) {
  std::vector<vtkMRMLNode*> masks{node->GetMaskNode()};
  for (int i = 0; i < node->GetNumberOfInputVolumeNodes(); ++i)
    masks.push_back(node->GetInputMaskNode(node->GetInputVolumeNode(i)));
  std::erase(masks, nullptr);
  return masks;
}

void setRequest(vtkMRMLInnerGSParameterNode* node, const Request& request) {
  const Request before = requestOf(node);
  vtkMRMLScene* scene = node->GetScene();
  QVector<InputChoice> inputs;
  for (const InputChoice& input : request.inputs)
    if (nodeOf<vtkMRMLVolumeNode>(scene, input.id)) inputs.append(input);

  MRMLNodeModifyBlocker blocker(node);
  if (inputs != before.inputs) {
    node->RemoveAllInputVolumeNodes();
    for (const InputChoice& input : inputs) {
      auto* volume = nodeOf<vtkMRMLVolumeNode>(scene, input.id);
      node->AddInputVolumeNode(volume);
      node->SetInputSliceThickness(volume, input.sliceThickness);
      node->SetInputSliceProfile(volume, input.sliceProfile);
      node->SetInputSliceAxis(volume, input.sliceAxis);
      node->SetInputMaskNode(volume, nodeOf<vtkMRMLNode>(scene, input.maskId));
      node->SetInputSlicePosesNode(volume, nodeOf<vtkMRMLNode>(scene, input.posesId));
    }
  }
  if (request.maskId != before.maskId) node->SetMaskNode(nodeOf<vtkMRMLNode>(scene, request.maskId));
  if (masksOf(request) != masksOf(before)) node->SetMaskSegmentID(""); // of a mask before
  if (request.regionId != before.regionId) node->SetROINode(nodeOf<vtkMRMLNode>(scene, request.regionId));
  node->SetOutputGrid(static_cast<int>(request.grid));
  node->SetOutputSpacing(request.spacing);
  if (request.referenceId != before.referenceId)
    node->SetReferenceVolumeNode(nodeOf<vtkMRMLVolumeNode>(scene, request.referenceId));
  if (request.outputVolumeId != before.outputVolumeId)
    node->SetOutputVolumeNode(nodeOf<vtkMRMLScalarVolumeNode>(scene, request.outputVolumeId));
  if (request.outputModelId != before.outputModelId)
    node->SetOutputModelNode(nodeOf<vtkMRMLInnerGSModelNode>(scene, request.outputModelId));
  node->SetSettings(request.settings);
  node->SetHeldOutFraction(request.heldOutFraction);
  node->SetResumeFileName(request.resumeFile.toStdString());
  node->SetEstimateUncertainty(request.estimateUncertainty);
  node->SetEvaluateQuality(request.evaluateQuality);
  node->SetQualityGap(request.qualityGap);
}

} // namespace innergs::ui
