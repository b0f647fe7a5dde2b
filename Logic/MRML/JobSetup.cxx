#include "JobSetup.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Device/Devices.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/RequestErrors.h"
#include "Core/Job/TimeEstimate.h"
#include "Core/Settings/SettingsTable.h"
#include "DynamicWork.h"
#include "Geometry.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "NodeGeometry.h"
#include "OutlineMask.h"
#include "SegmentationMask.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLLabelMapVolumeNode.h>
#include <vtkMRMLMarkupsROINode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLTableNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkCallbackCommand.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <cmath>

namespace innergs::mrml {

vtkStandardNewMacro(JobFilter);

JobFilter::JobFilter() {
  this->KeepModelWhenAbortedOn(); // for keepFit()
}
JobFilter::~JobFilter() = default;

ReconstructionResult JobFilter::Reconstruct(ReconstructionInput&& input, const Settings& settings,
                                            const std::stop_token& stop) {
  if (!masks.empty()) {
    std::vector<Mask> all;
    auto own = input.masks.begin();
    for (const auto& segmentation : std::exchange(masks, {}))
      all.push_back(segmentation ? segmentation->make(stop, *unstoppable) : std::move(*own++));
    input.masks = std::move(all);
  }
  if (!resumeFile.empty()) input.resume = std::make_shared<const Model>(readModel(resumeFile));
  JudgedReconstruction job(std::move(input), settings, keepEvery);
  job.onProgress([this](const innergs::Progress& progress) { ReportProgress(progress); });
  job.onPreview([this](const Volume& volume) { ReportPreview(volume); });
  JudgedResult result = job.run(stop);
  quality = std::move(result.quality);
  return std::move(result.reconstruction);
}

void dropResumedFile(const Task& task) {
  if (task.filter) dropRecoveredFit(task.filter->resumeFile, task.recoveryFolder);
  if (task.dynamic) dropRecoveredFit(task.dynamic->resumeFile(), task.recoveryFolder);
}

void keepFit(Task& task) {
  vtkInnerGSModel* reached = task.filter ? task.filter->GetOutputModel() : nullptr;
  if (!task.recovered.file.empty() || (!task.dynamic && (!reached || reached->IsEmpty()))) return;
  try {
    if (task.dynamic) {
      task.dynamic->keep(task.recovered, task.recoveryFolder);
      if (!task.recovered.file.empty()) dropResumedFile(task);
      return;
    }
    const auto model = reached->GetCoreModel();
    task.recovered.iteration = model->iteration;
    task.recovered.iterations = task.cancelled ? task.filter->GetTotalIterations() : model->iteration;
    task.recovered.file = writeRecoveredFit(*model, task.recovered, task.recoveryFolder);
    dropResumedFile(task);
  } catch (...) {
    task.notKept = failureOf();
  }
}

void JobFilter::ReportProgress(const innergs::Progress& progress) {
  this->Superclass::ReportProgress(progress);
  if (told) told(progress);
}

namespace {

using Parameters = vtkMRMLInnerGSParameterNode;

/// An image of its own with the same voxels, so that a worker touches no node's image.
vtkSmartPointer<vtkImageData> sharing(vtkImageData* image) {
  auto own = vtkSmartPointer<vtkImageData>::New();
  own->ShallowCopy(image);
  return own;
}

[[noreturn]] void refuse(ErrorCode code, const std::string& sentence) {
  throw Error(code, sentence);
}

/// The node that a role refers to; null when there is none. Throws when it is of another type or gone.
template <class Node>
Node* referenced(Parameters* parameters, const char* role, int index, const std::string& what,
                 const std::string& kind) {
  const char* id = parameters->GetNthNodeReferenceID(role, index);
  if (!id) return nullptr;
  vtkMRMLNode* node = parameters->GetNthNodeReference(role, index);
  if (!node) refuse(ErrorCode::InvalidArgument, what + " is no longer in the scene: choose another.");
  Node* typed = Node::SafeDownCast(node);
  if (!typed)
    refuse(ErrorCode::InvalidArgument, what + " " + quoted(node) + " is not " + kind + ": choose one.");
  return typed;
}

std::vector<vtkMRMLVolumeNode*> inputsOf(Parameters* parameters) {
  std::vector<vtkMRMLVolumeNode*> inputs;
  for (int n = 0; n < parameters->GetNumberOfInputVolumeNodes(); ++n) {
    auto* input = referenced<vtkMRMLScalarVolumeNode>(parameters, Parameters::GetInputVolumeReferenceRole(),
                                                      n, "The input", "a scalar volume");
    if (!input) continue;
    if (vtkMRMLLabelMapVolumeNode::SafeDownCast(input))
      refuse(ErrorCode::UnsupportedImage,
             "The input " + quoted(input) + " is a labelmap: choose the scan that it belongs to.");
    inputs.push_back(input);
  }
  if (inputs.empty()) throw noInputError();
  return inputs;
}

vtkMRMLTransformableNode* ownMaskOf(Parameters* parameters, vtkMRMLVolumeNode* input) {
  if (!parameters->HasInputMask(input)) return nullptr;
  vtkMRMLNode* mask = parameters->GetInputMaskNode(input);
  if (!mask)
    refuse(ErrorCode::InvalidArgument,
           "The mask of " + quoted(input) + " is no longer in the scene: choose another.");
  auto* placed = vtkMRMLTransformableNode::SafeDownCast(mask);
  if (!placed)
    refuse(ErrorCode::InvalidArgument,
           "The mask " + quoted(mask) + " is neither a labelmap nor a segmentation: choose one.");
  return placed;
}

/// None, one for all inputs, or one for each.
std::vector<vtkMRMLTransformableNode*> masksOf(Parameters* parameters) {
  auto* common = referenced<vtkMRMLTransformableNode>(parameters, Parameters::GetMaskReferenceRole(), 0,
                                                      "The mask", "a labelmap or segmentation");
  const std::vector<vtkMRMLVolumeNode*> inputs = inputsOf(parameters);
  std::vector<vtkMRMLTransformableNode*> own;
  for (vtkMRMLVolumeNode* input : inputs)
    own.push_back(ownMaskOf(parameters, input));
  if (std::all_of(own.begin(), own.end(), [](auto* mask) { return !mask; }))
    return common ? std::vector{common} : std::vector<vtkMRMLTransformableNode*>{};
  for (std::size_t n = 0; n < own.size(); ++n) {
    if (!own[n]) own[n] = common;
    if (!own[n]) throw noMaskError(nameOf(inputs[n]));
  }
  return own;
}

/// Only checks that segmentations are usable: they are copied at the start.
void setMasks(vtkInnerGSReconstruct* filter, Parameters* parameters) {
  int index = 0;
  for (vtkMRMLTransformableNode* node : masksOf(parameters)) {
    if (auto* segmentation = vtkMRMLSegmentationNode::SafeDownCast(node)) {
      SegmentationMask::check(segmentation, parameters->GetMaskSegmentID());
      continue;
    }
    auto* volume = vtkMRMLVolumeNode::SafeDownCast(node);
    if (!volume)
      refuse(ErrorCode::InvalidArgument,
             "The mask " + quoted(node) + " is neither a labelmap nor a segmentation: choose one.");
    if (!volume->GetImageData())
      refuse(ErrorCode::NoData, "The mask " + quoted(node) + " has no voxels: choose another or none.");
    vtkNew<vtkMatrix4x4> matrix;
    ijkToWorld(volume, matrix);
    filter->AddMaskData(sharing(volume->GetImageData()));
    filter->SetMaskIJKToRASMatrix(index++, matrix);
  }
}

/// The grids that the mask of this index is for: those of all inputs, or of its own.
std::vector<GridGeometry> gridsOf(const ReconstructionInput& input, std::size_t mask, std::size_t masks) {
  std::vector<GridGeometry> grids;
  for (std::size_t s = 0; s < input.stacks.size(); ++s)
    if (masks == 1 || s == mask) grids.push_back(input.stacks[s].image.geometry);
  return grids;
}

/// Copies what the masks need of segmentations while this is the main thread.
void takeMasks(JobFilter* filter, Parameters* parameters, const std::vector<vtkMRMLVolumeNode*>& inputs) {
  const std::vector<vtkMRMLTransformableNode*> nodes = masksOf(parameters);
  bool segmentations = false;
  std::vector<std::unique_ptr<SegmentationMask>> masks(nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n)
    if (auto* node = vtkMRMLSegmentationNode::SafeDownCast(nodes[n])) {
      std::vector<GridGeometry> grids;
      filter->WithOutline([&](const ReconstructionInput& input) { grids = gridsOf(input, n, nodes.size()); });
      masks[n] = std::make_unique<SegmentationMask>(node, parameters->GetMaskSegmentID(), inputs[n], grids);
      segmentations = true;
    }
  if (segmentations) filter->masks = std::move(masks);
}

void setReference(vtkInnerGSReconstruct* filter, const GridGeometry& grid) {
  vtkNew<vtkMatrix4x4> matrix;
  vtk::toMatrix(grid, matrix);
  filter->SetReferenceGrid(matrix, static_cast<int>(grid.size[0]), static_cast<int>(grid.size[1]),
                           static_cast<int>(grid.size[2]));
}

void setGrid(vtkInnerGSReconstruct* filter, Parameters* parameters,
             const std::vector<vtkMRMLVolumeNode*>& inputs) {
  auto* roi = referenced<vtkMRMLMarkupsROINode>(parameters, Parameters::GetROIReferenceRole(), 0,
                                                "The region", "a markups ROI");
  std::optional<GridGeometry> box;
  if (roi) {
    box = boxOf(roi);
    double size[3];
    roi->GetSize(size);
    filter->SetRegion(-size[0] / 2, size[0] / 2, -size[1] / 2, size[1] / 2, -size[2] / 2, size[2] / 2);
    filter->SetRegionToRASMatrix(roi->GetObjectToWorldMatrix());
    filter->UseRegionOn();
  }
  double spacing = 0; // mm, 0: chosen
  switch (parameters->GetOutputGrid()) {
  case Parameters::ReferenceGrid: {
    auto* reference = referenced<vtkMRMLVolumeNode>(parameters, Parameters::GetReferenceVolumeReferenceRole(),
                                                    0, "The reference", "a volume");
    if (!reference) throw noReferenceError();
    setReference(filter, gridOf(reference));
    return;
  }
  case Parameters::InputGrid: {
    const GridGeometry grid = gridOf(inputs.front());
    setReference(filter, box ? cropped(grid, *box) : grid);
    return;
  }
  case Parameters::SpacingGrid:
    spacing = parameters->GetOutputSpacing();
    if (!(spacing > 0) || !std::isfinite(spacing))
      refuse(ErrorCode::InvalidArgument, "The output spacing must be above 0 mm.");
    filter->SetOutputSpacing(spacing, spacing, spacing);
    break;
  default:
    break;
  }
  if (!box) return;
  if (spacing == 0) {
    spacing = 1e300;
    for (vtkMRMLVolumeNode* input : inputs)
      for (double s : gridOf(input).spacing)
        spacing = std::min(spacing, s);
  }
  setReference(filter, withSpacing(*box, {spacing, spacing, spacing}));
}

void checkOutputs(Parameters* parameters, const std::vector<vtkMRMLVolumeNode*>& inputs, Task& task) {
  task.volume = referenced<vtkMRMLScalarVolumeNode>(parameters, Parameters::GetOutputVolumeReferenceRole(), 0,
                                                    "The output", "a scalar volume");
  task.model = referenced<vtkMRMLInnerGSModelNode>(parameters, Parameters::GetOutputModelReferenceRole(), 0,
                                                   "The output model", "an InnerGS model");
  task.table = referenced<vtkMRMLTableNode>(parameters, Parameters::GetQualityTableReferenceRole(), 0,
                                            "The quality table", "a table");
  task.uncertainty =
      referenced<vtkMRMLScalarVolumeNode>(parameters, Parameters::GetOutputUncertaintyReferenceRole(), 0,
                                          "The output of the uncertainty", "a scalar volume");
  task.newVolume = !task.volume;
  task.newModel = !task.model;
  task.newTable = !task.table;
  task.newUncertainty = !task.uncertainty;
  for (vtkMRMLNode* output : {task.volume.Get(), task.uncertainty.Get()}) {
    if (!output) continue;
    if (std::find(inputs.begin(), inputs.end(), output) != inputs.end())
      throw outputIsInputError(nameOf(output));
    const auto masks = masksOf(parameters);
    if (std::find(masks.begin(), masks.end(), output) != masks.end() ||
        output == parameters->GetReferenceVolumeNode())
      throw outputIsMaskError(nameOf(output));
    if (vtkMRMLLabelMapVolumeNode::SafeDownCast(output))
      refuse(ErrorCode::InvalidArgument,
             "The output " + quoted(output) + " is a labelmap: choose a scalar volume.");
  }
  if (task.volume && task.volume == task.uncertainty)
    refuse(ErrorCode::InvalidArgument, "The output " + quoted(task.volume) +
                                           " is that of the uncertainty as well: choose another for one.");
}

/// Null: the slices lie where the volume puts them.
vtkSmartPointer<vtkDoubleArray> slicePosesOf(Parameters* parameters, vtkMRMLVolumeNode* input) {
  if (!parameters->HasInputSlicePoses(input)) return nullptr;
  auto* sequence = vtkMRMLSequenceNode::SafeDownCast(parameters->GetInputSlicePosesNode(input));
  if (!sequence)
    refuse(ErrorCode::InvalidArgument,
           "The slice poses of " + quoted(input) +
               " are no sequence in the scene: choose one of linear transforms, or none.");
  auto poses = vtkSmartPointer<vtkDoubleArray>::New();
  poses->SetNumberOfComponents(16);
  vtkNew<vtkMatrix4x4> matrix;
  for (int k = 0; k < sequence->GetNumberOfDataNodes(); ++k) {
    auto* transform = vtkMRMLTransformNode::SafeDownCast(sequence->GetNthDataNode(k));
    if (!transform || !transform->IsLinear())
      refuse(ErrorCode::InvalidArgument, "Item " + std::to_string(k) + " of " + quoted(sequence) +
                                             " is no linear transform: slice poses are one for each slice.");
    transform->GetMatrixTransformToParent(matrix);
    poses->InsertNextTuple(matrix->GetData());
  }
  return poses;
}

void configure(vtkInnerGSReconstruct* filter, Parameters* parameters, const ThicknessOf& thicknessOf) {
  const std::vector<vtkMRMLVolumeNode*> inputs = inputsOf(parameters);
  filter->SetSettings(parameters->GetSettings());
  filter->SetHeldOutFraction(parameters->GetHeldOutFraction());
  filter->SetEstimateUncertainty(parameters->GetEstimateUncertainty());
  filter->GeometryInImageOff(); // volume nodes keep it themselves
  for (std::size_t n = 0; n < inputs.size(); ++n) {
    vtkMRMLVolumeNode* input = inputs[n];
    const int index = static_cast<int>(n);
    if (!input->GetImageData() || input->GetImageData()->GetNumberOfPoints() == 0)
      refuse(ErrorCode::NoData,
             "The input " + quoted(input) + " has no voxels: load or choose another volume.");
    vtkNew<vtkMatrix4x4> matrix;
    ijkToWorld(input, matrix);
    filter->AddInputData(sharing(input->GetImageData()));
    filter->SetInputIJKToRASMatrix(index, matrix);
    filter->SetInputName(index, nameOf(input));
    filter->SetInputSliceProfile(index, parameters->GetInputSliceProfile(input));
    filter->SetInputSlicePoses(index, slicePosesOf(parameters, input));
    const int automatic = sliceAxis(matrix), chosen = parameters->GetInputSliceAxis(input);
    const int axis = chosen == Parameters::Automatic ? automatic : chosen;
    filter->SetInputSliceAxis(index, axis);
    const double thickness = parameters->GetInputSliceThickness(input);
    const bool acquired = axis == automatic && axis == 2; // along K, as DICOM slices are stacked
    filter->SetInputSliceThickness(index, thickness == 0 && acquired ? thicknessOf(input) : thickness);
  }
  setMasks(filter, parameters);
  setGrid(filter, parameters, inputs);
}

vtkSmartPointer<JobFilter> filterFor(Parameters* parameters, vtkMRMLScene* scene,
                                     const ThicknessOf& thicknessOf, Task& task) {
  if (!parameters) refuse(ErrorCode::InvalidArgument, "There is no parameter node: create one first.");
  if (!scene || parameters->GetScene() != scene)
    refuse(ErrorCode::InvalidArgument, "The parameter node is not in the scene: add it first.");
  checkOutputs(parameters, inputsOf(parameters), task);
  auto filter = vtkSmartPointer<JobFilter>::New();
  vtkNew<vtkCallbackCommand> quiet; // the caller takes the sentence from the filter
  filter->AddObserver(vtkCommand::ErrorEvent, quiet);
  configure(filter, parameters, thicknessOf);
  checkSettings(filter->GetSettings());
  checkHeldOutFraction(parameters->GetHeldOutFraction());
  if (const std::string file = parameters->GetResumeFileName(); !file.empty()) {
    filter->resumeFile = pathOf(file);
    checkInputFile(filter->resumeFile);
  }
  if (parameters->GetEvaluateQuality()) checkKeepEvery(*(filter->keepEvery = parameters->GetQualityGap()));
  return filter;
}

} // namespace

vtkSmartPointer<JobFilter> check(Parameters* parameters, vtkMRMLScene* scene,
                                 const ThicknessOf& thicknessOf) {
  Task ignored;
  auto filter = filterFor(parameters, scene, thicknessOf, ignored);
  filter->WithOutline([](const ReconstructionInput&) {}); // throws if the region misses the images
  return filter;
}

std::string describeDevice(Parameters* parameters) {
  vtkNew<JobFilter> filter;
  filter->SetSettings(parameters->GetSettings());
  return filter->DescribeDevice();
}

JobOutline outlineOf(Parameters* parameters, vtkMRMLScene* scene, const ThicknessOf& thicknessOf,
                     std::vector<OutlineMask>& masks) {
  const auto filter = check(parameters, scene, thicknessOf);
  JobOutline outline;
  outline.settings = filter->GetSettings();
  filter->WithOutline([&](ReconstructionInput input) {
    const std::vector<vtkMRMLVolumeNode*> inputs = inputsOf(parameters);
    const std::vector<vtkMRMLTransformableNode*> nodes = masksOf(parameters);
    masks.resize(nodes.size());
    input.masks.clear();
    for (std::size_t n = 0; n < nodes.size(); ++n)
      if (const Mask* inside = masks[n].of(nodes[n], parameters->GetMaskSegmentID(), inputs[n],
                                           gridsOf(input, n, nodes.size())))
        input.masks.push_back(*inside);
    if (input.masks.size() < nodes.size()) input.masks.clear();
    outline.fits = fitOutlines(input, filter->keepEvery);
  });
  return outline;
}

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names)
    text += (&name == &names.front() ? "" : "; ") + name;
  return text;
}

std::shared_ptr<Task> prepare(Parameters* parameters, vtkMRMLScene* scene, const ThicknessOf& thicknessOf,
                              bool copy) {
  auto task = std::make_shared<Task>();
  task->filter = filterFor(parameters, scene, thicknessOf, *task);
  const std::vector<vtkMRMLVolumeNode*> inputs = inputsOf(parameters);
  takeMasks(task->filter, parameters, inputs);
  if (copy && !task->filter->TakeSnapshot()) task->filter->RethrowError();
  for (vtkMRMLVolumeNode* input : inputs)
    task->inputNames.emplace_back(nameOf(input));
  std::vector<std::string> masks;
  for (vtkMRMLNode* mask : masksOf(parameters))
    masks.emplace_back(nameOf(mask));
  task->maskName = joined(masks);
  task->recovered.inputs = joined(task->inputNames);
  task->recovered.mask = task->maskName;
  task->recovered.settings = task->filter->GetSettings();
  task->scene = scene;
  task->parameters = parameters;
  task->firstInput = inputs.front();
  return task;
}

} // namespace innergs::mrml
