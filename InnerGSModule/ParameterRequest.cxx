#include "ParameterRequest.h"

#include "NodeInfo.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>

#include <algorithm>
#include <limits>

namespace innergs::ui {
namespace {

template <class Node>
Node* nodeOf(vtkMRMLNode* owner, const QString& id) {
  vtkMRMLScene* scene = owner->GetScene();
  return scene && !id.isEmpty() ? Node::SafeDownCast(scene->GetNodeByID(id.toUtf8().constData())) : nullptr;
}

/// −1 in the node: chosen by the program.
template <class T>
std::optional<T> chosen(int value) {
  return value < 0 ? std::nullopt : std::optional<T>(static_cast<T>(value));
}
template <class T>
int stored(const std::optional<T>& value) {
  return value ? static_cast<int>(*value) : -1;
}
/// 0 in the node for counts.
template <class T>
std::optional<T> count(int value) {
  return value > 0 ? std::optional<T>(value) : std::nullopt;
}
template <class T>
int storedCount(const std::optional<T>& value) {
  return value ? static_cast<int>(*value) : 0;
}
std::optional<double> weight(double value) {
  return value < 0 ? std::nullopt : std::optional<double>(value);
}

Settings settingsOf(vtkMRMLInnerGSParameterNode* node) {
  Settings s;
  s.preset = static_cast<Preset>(node->GetPreset());
  s.blending = chosen<Blending>(node->GetBlending());
  s.selection = static_cast<Selection>(node->GetSelection());
  s.cutoff = weight(node->GetCutoff());
  s.beta1 = weight(node->GetBeta1());
  s.beta2 = weight(node->GetBeta2());
  s.linearIntensity = chosen<bool>(node->GetLinearIntensity());
  s.initialisation = chosen<Initialisation>(node->GetInitialisation());
  s.loss = chosen<LossKind>(node->GetLoss());
  s.pointWeight = weight(node->GetPointWeight());
  s.ssimWeight = weight(node->GetSSIMWeight());
  s.huberDelta = node->GetHuberDelta();
  s.gaussians = count<std::int64_t>(node->GetNumberOfGaussians());
  s.maxGaussians = count<std::int64_t>(node->GetMaximumNumberOfGaussians());
  s.iterations = count<int>(node->GetNumberOfIterations());
  s.ensembleSize = count<int>(node->GetEnsembleSize());
  s.schedule = chosen<Schedule>(node->GetSchedule());
  s.plateau = {node->GetPlateauPatience(), node->GetPlateauFactor(), node->GetPlateauLowest(),
               node->GetPlateauThreshold()};
  s.densifyEvery = chosen<int>(node->GetDensifyEvery());
  s.densify = {weight(node->GetPruneOpacity()), node->GetPruneSize(), node->GetDensifyGradient(),
               node->GetSplitSize()};
  s.allAxes = chosen<bool>(node->GetAllAxes());
  s.paperStopRule = chosen<bool>(node->GetPaperStopRule());
  s.relocate = node->GetRelocate();
  s.consistency = node->GetConsistency();
  s.fill = node->GetFillValue();
  s.threads = node->GetNumberOfThreads();
  s.instructionSet = node->GetInstructionSet();
  s.device = node->GetDevice();
  s.seed = static_cast<std::uint64_t>(node->GetSeed());
  return s;
}

void setSettings(vtkMRMLInnerGSParameterNode* node, const Settings& s) {
  node->SetPreset(static_cast<int>(s.preset));
  node->SetBlending(stored(s.blending));
  node->SetSelection(static_cast<int>(s.selection));
  node->SetCutoff(s.cutoff.value_or(-1));
  node->SetBeta1(s.beta1.value_or(-1));
  node->SetBeta2(s.beta2.value_or(-1));
  node->SetLinearIntensity(stored(s.linearIntensity));
  node->SetInitialisation(stored(s.initialisation));
  node->SetLoss(stored(s.loss));
  node->SetPointWeight(s.pointWeight.value_or(-1));
  node->SetSSIMWeight(s.ssimWeight.value_or(-1));
  node->SetHuberDelta(s.huberDelta);
  node->SetNumberOfGaussians(storedCount(s.gaussians));
  node->SetMaximumNumberOfGaussians(storedCount(s.maxGaussians));
  node->SetNumberOfIterations(storedCount(s.iterations));
  node->SetEnsembleSize(storedCount(s.ensembleSize));
  node->SetSchedule(stored(s.schedule));
  node->SetPlateauPatience(s.plateau.patience);
  node->SetPlateauFactor(s.plateau.factor);
  node->SetPlateauLowest(s.plateau.lowest);
  node->SetPlateauThreshold(s.plateau.threshold);
  node->SetDensifyEvery(stored(s.densifyEvery));
  node->SetPruneOpacity(s.densify.opacity.value_or(-1));
  node->SetPruneSize(s.densify.size);
  node->SetDensifyGradient(s.densify.gradient);
  node->SetSplitSize(s.densify.split);
  node->SetAllAxes(stored(s.allAxes));
  node->SetPaperStopRule(stored(s.paperStopRule));
  node->SetRelocate(s.relocate);
  node->SetConsistency(s.consistency);
  node->SetFillValue(s.fill);
  node->SetNumberOfThreads(s.threads);
  node->SetInstructionSet(s.instructionSet);
  node->SetDevice(s.device);
  node->SetSeed(static_cast<int>(std::min<std::uint64_t>(s.seed, std::numeric_limits<int>::max())));
}

} // namespace

Request requestOf(vtkMRMLInnerGSParameterNode* node) {
  Request request;
  for (int i = 0; i < node->GetNumberOfInputVolumeNodes(); ++i)
    if (vtkMRMLVolumeNode* input = node->GetInputVolumeNode(i))
      request.inputs.append({idOf(input), node->GetInputSliceThickness(input),
                             node->GetInputSliceProfile(input), node->GetInputSliceAxis(input)});
  request.maskId = idOf(node->GetMaskNode());
  request.regionId = idOf(node->GetROINode());
  request.grid = static_cast<OutputGrid>(node->GetOutputGrid());
  request.spacing = node->GetOutputSpacing();
  request.referenceId = idOf(node->GetReferenceVolumeNode());
  request.outputVolumeId = idOf(node->GetOutputVolumeNode());
  request.outputModelId = idOf(node->GetOutputModelNode());
  request.settings = settingsOf(node);
  request.heldOutFraction = node->GetHeldOutFraction();
  request.evaluateQuality = node->GetEvaluateQuality();
  request.qualityGap = node->GetQualityGap();
  return request;
}

void setRequest(vtkMRMLInnerGSParameterNode* node, const Request& request) {
  const Request before = requestOf(node);
  QVector<InputChoice> inputs;
  for (const InputChoice& input : request.inputs)
    if (nodeOf<vtkMRMLVolumeNode>(node, input.id)) inputs.append(input);

  MRMLNodeModifyBlocker blocker(node);
  if (inputs != before.inputs) {
    node->RemoveAllInputVolumeNodes();
    for (const InputChoice& input : inputs) {
      auto* volume = nodeOf<vtkMRMLVolumeNode>(node, input.id);
      node->AddInputVolumeNode(volume);
      node->SetInputSliceThickness(volume, input.sliceThickness);
      node->SetInputSliceProfile(volume, input.sliceProfile);
      node->SetInputSliceAxis(volume, input.sliceAxis);
    }
  }
  if (request.maskId != before.maskId) { // a segment is one of the mask before
    node->SetMaskSegmentID("");
    node->SetMaskNode(nodeOf<vtkMRMLNode>(node, request.maskId));
  }
  if (request.regionId != before.regionId) node->SetROINode(nodeOf<vtkMRMLNode>(node, request.regionId));
  node->SetOutputGrid(static_cast<int>(request.grid));
  node->SetOutputSpacing(request.spacing);
  if (request.referenceId != before.referenceId)
    node->SetReferenceVolumeNode(nodeOf<vtkMRMLVolumeNode>(node, request.referenceId));
  if (request.outputVolumeId != before.outputVolumeId)
    node->SetOutputVolumeNode(nodeOf<vtkMRMLScalarVolumeNode>(node, request.outputVolumeId));
  if (request.outputModelId != before.outputModelId)
    node->SetOutputModelNode(nodeOf<vtkMRMLInnerGSModelNode>(node, request.outputModelId));
  setSettings(node, request.settings);
  node->SetHeldOutFraction(request.heldOutFraction);
  node->SetEvaluateQuality(request.evaluateQuality);
  node->SetQualityGap(request.qualityGap);
}

} // namespace innergs::ui
