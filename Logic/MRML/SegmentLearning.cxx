#include "SegmentLearning.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Device/FeatureDeviceChoice.h"
#include "Core/Features/Teacher.h"
#include "Core/Model/Model.h"
#include "Core/Render/Render.h"
#include "DetachedTasks.h"
#include "Geometry.h"
#include "IO/FilePath.h"
#include "IO/TextEmbeddingIO.h"
#include "ImageVoxels.h"
#include "NodeGeometry.h"
#include "Onnx/DenseNetwork.h"
#include "Queries.h"
#include "SegmentationMask.h"
#include "Text/SegmentedModel.h"
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLColorNode.h>
#include <vtkMRMLDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>

namespace innergs::mrml {
namespace {

/// Labels as the worker needs them.
struct TrainingLabels {
  std::unique_ptr<SegmentationMask> segmentation; // or
  Volume volume;                                  // of labels, in the world
  std::vector<SegmentName> names;
  vtkNew<vtkMatrix4x4> worldToModel;

  /// In the model's own coordinates; uses them up.
  NamedLabels labels(const std::stop_token& stop, DetachedTasks& unstoppable);
};

/// A grid of the world in the model's own coordinates. Throws Error(Geometry) where that shears it.
GridGeometry inModel(const GridGeometry& world, vtkMatrix4x4* worldToModel) {
  vtkNew<vtkMatrix4x4> ijkToWorld, ijkToModel;
  vtk::toMatrix(world, ijkToWorld);
  vtkMatrix4x4::Multiply4x4(worldToModel, ijkToWorld, ijkToModel);
  const int size[3] = {static_cast<int>(world.size[0]), static_cast<int>(world.size[1]),
                       static_cast<int>(world.size[2])};
  const int first[3] = {0, 0, 0};
  return vtk::gridOf(ijkToModel, size, first, "The labels, seen from the model,");
}

NamedLabels TrainingLabels::labels(const std::stop_token& stop, DetachedTasks& unstoppable) {
  NamedLabels given{segmentation ? segmentation->makeLabels(stop, unstoppable) : labelmapOf(volume), names};
  volume = {};
  given.labels.geometry = inModel(given.labels.geometry, worldToModel);
  return given;
}

/// The grid of the model's region in the world. Throws Error(Geometry).
void regionInWorld(vtkMRMLInnerGSModelNode* model, vtkMatrix4x4* ijkToWorld, int size[3]) {
  vtkNew<vtkMatrix4x4> ijkToModel, modelToWorld;
  if (!model->GetModel()->GetDomain(ijkToModel, size))
    throw Error(ErrorCode::Geometry,
                "The model " + quoted(model) +
                    " does not say which region it was fitted to: reconstruct it again.");
  toWorld(model, modelToWorld);
  vtkMatrix4x4::Multiply4x4(modelToWorld, ijkToModel, ijkToWorld);
}

void takeSegmentation(vtkMRMLInnerGSModelNode* model, vtkMRMLSegmentationNode* node,
                      TrainingLabels& training) {
  vtkNew<vtkMatrix4x4> region;
  int size[3];
  regionInWorld(model, region, size);
  const int first[3] = {0, 0, 0};
  vtkNew<vtkMRMLScalarVolumeNode> like; // for voxels made from surfaces
  vtkNew<vtkImageData> voxels;
  voxels->SetDimensions(size);
  like->SetAndObserveImageData(voxels);
  like->SetIJKToRASMatrix(region);
  training.segmentation = std::make_unique<SegmentationMask>(
      node, "", like, std::vector<GridGeometry>{vtk::gridOf(region, size, first, quoted(model))},
      "segmentation");
  const auto& names = training.segmentation->names();
  for (std::size_t n = 0; n < names.size(); ++n) {
    if (names[n].empty())
      throw Error(ErrorCode::InvalidArgument, "Segment " + std::to_string(n + 1) + " of " + quoted(node) +
                                                  " has no name: name it, e.g. \"liver\".");
    training.names.push_back({static_cast<std::uint16_t>(n + 1), names[n]});
  }
}

void takeLabelMap(vtkMRMLVolumeNode* node, TrainingLabels& training) {
  const std::string what = "The labelmap " + quoted(node);
  vtk::checkVoxels(node->GetImageData(), what);
  training.volume.geometry = gridOf(node);
  training.volume.voxels =
      vtk::voxelsOf(node->GetImageData(), {{0, 0, 0}, training.volume.geometry.size}, what);
  auto* colors = node->GetDisplayNode() ? node->GetDisplayNode()->GetColorNode() : nullptr;
  for (int n = 1; colors && n < std::min(65536, colors->GetNumberOfColors()); ++n)
    if (const char* name = colors->GetColorName(n); name && *name && std::string(name) != "(none)")
      training.names.push_back({static_cast<std::uint16_t>(n), name});
  if (training.names.empty())
    throw Error(ErrorCode::InvalidArgument,
                what + " has no colour table that names its labels: choose one in the Volumes module, or "
                       "convert it to a segmentation and name its segments.");
}

void checkInScene(vtkMRMLInnerGSModelNode* model, vtkMRMLScene* scene) {
  modelOf(model);
  if (!scene || model->GetScene() != scene)
    throw Error(ErrorCode::InvalidArgument, "The model is not in the scene: add it first.");
}

std::shared_ptr<TrainingLabels> trainingLabelsOf(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels,
                                                 vtkMRMLScene* scene) {
  auto training = std::make_shared<TrainingLabels>();
  checkInScene(model, scene);
  if (!labels)
    throw Error(ErrorCode::InvalidArgument,
                "There is nothing to learn from: choose a segmentation or labelmap.");
  fromWorld(model, training->worldToModel);
  if (auto* segmentation = vtkMRMLSegmentationNode::SafeDownCast(labels))
    takeSegmentation(model, segmentation, *training);
  else if (auto* volume = vtkMRMLVolumeNode::SafeDownCast(labels))
    takeLabelMap(volume, *training);
  else
    throw Error(ErrorCode::InvalidArgument,
                quoted(labels) + " is neither a segmentation nor a labelmap: choose one.");
  return training;
}

/// Makes the teacher, on the worker; progress: of making it.
using TeacherMaker = std::function<Teacher(const std::stop_token&, DetachedTasks&,
                                           const std::function<void(double)>& progress)>;

/// making: the share of the progress until there is a teacher.
std::shared_ptr<Task> learningTask(vtkMRMLInnerGSModelNode* model, vtkMRMLScene* scene,
                                   const std::string& from, double making, TeacherMaker makeTeacher) {
  const SegmentedModel segmented = model->GetModel()->GetSegmented();
  const auto learned = std::make_shared<std::shared_ptr<const FeatureModel>>();
  auto task = std::make_shared<Task>();
  task->scene = scene;
  task->model = model;
  task->newModel = false;
  task->work = [segmented, learned, making, makeTeacher = std::move(makeTeacher)](
                   const std::stop_token& stop, DetachedTasks& unstoppable, const ProgressCallback& told) {
    const auto start = std::chrono::steady_clock::now();
    const auto report = [&](double fraction) {
      Progress progress;
      progress.phase = Phase::Fitting;
      progress.fraction = fraction;
      progress.gaussians = segmented.field->size();
      progress.elapsed = secondsSince(start);
      progress.remaining = fraction > 0 ? progress.elapsed * (1 - fraction) / fraction : 0;
      told(progress);
    };
    const Teacher teacher =
        makeTeacher(stop, unstoppable, [&](double fraction) { report(making * fraction); });
    FeatureTraining training;
    training.stop = stop;
    training.devices = std::make_shared<FeatureDeviceChoice>("auto");
    training.progress = [&](double fraction) { report(making + (1 - making) * fraction); };
    *learned = std::make_shared<const FeatureModel>(trainFrom(segmented, teacher, training));
  };
  task->deliver = [segmented, learned, from, target = vtkWeakPointer<vtkMRMLInnerGSModelNode>(model)] {
    const vtkSmartPointer<vtkMRMLInnerGSModelNode> node = target.Get(); // an observer may remove it
    const SegmentedModel now = node && !node->IsEmpty() ? node->GetModel()->GetSegmented() : SegmentedModel();
    if (segmented.dynamic ? now.dynamic != segmented.dynamic : now.field != segmented.field)
      throw Error(ErrorCode::InvalidArgument,
                  "The model was replaced while learning: learn the segments again.");
    MRMLNodeModifyBlocker blocker(node);
    node->SetAttribute("InnerGS.Segments", from.c_str());
    node->SetFeatures(*learned);
  };
  return task;
}

} // namespace

std::shared_ptr<Task> prepareLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse,
                                      vtkMRMLScene* scene) {
  const auto training = trainingLabelsOf(model, labels, scene);
  return learningTask(
      model, scene, nameOf(labels), 0,
      [training, sparse](const std::stop_token& stop, DetachedTasks& unstoppable, const auto&) {
        NamedLabels given = training->labels(stop, unstoppable);
        if (sparse) given.labels = withSparseSlices(given.labels);
        return Teacher(std::move(given));
      });
}

std::shared_ptr<Task> prepareFeatureLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLVolumeNode* features,
                                             const std::string& textsFile, vtkMRMLScene* scene) {
  checkInScene(model, scene);
  if (!features)
    throw Error(ErrorCode::InvalidArgument, "There is nothing to learn from: choose a feature volume.");
  const std::string what = "The feature volume " + quoted(features);
  const auto dense = std::make_shared<DenseTeacher>();
  vtkNew<vtkMatrix4x4> worldToModel;
  fromWorld(model, worldToModel);
  dense->features.geometry = inModel(gridOf(features), worldToModel);
  dense->features.channels = vtk::componentsOf(features->GetImageData(), what);
  dense->texts = readTextEmbeddings(pathOf(textsFile));
  return learningTask(model, scene, nameOf(features), 0,
                      [dense](const auto&...) { return Teacher(std::move(*dense)); });
}

std::shared_ptr<Task> prepareNetworkLearning(vtkMRMLInnerGSModelNode* model, const NetworkTeacher& network,
                                             vtkMRMLScene* scene) {
  checkInScene(model, scene);
  std::vector<SegmentName> names;
  for (const std::string& name : network.names)
    names.push_back({static_cast<std::uint16_t>(names.size() + 1), name});
  std::vector<TextEmbedding> texts;
  if (!network.textsFile.empty()) texts = readTextEmbeddings(pathOf(network.textsFile));
  DenseNetworkOptions options;
  options.spacing = network.spacing;
  if (network.range[0] != network.range[1])
    options.range = ValueRange{static_cast<float>(network.range[0]), static_cast<float>(network.range[1])};
  const auto core = model->GetModel()->GetCoreModel();
  return learningTask(model, scene, network.file, 0.5,
                      [core, names, texts, options, file = pathOf(network.file)](
                          const std::stop_token& stop, DetachedTasks&, const auto& progress) {
                        DenseNetworkOptions own = options;
                        own.stop = stop;
                        own.progress = progress;
                        RenderOptions rendering;
                        rendering.stop = stop;
                        return networkTeacher(file, render(core->field, core->field.region(), rendering),
                                              names, texts, own);
                      });
}

std::function<NamedLabels(const std::stop_token&)> labelsLater(vtkMRMLInnerGSModelNode* model,
                                                               vtkMRMLNode* labels, vtkMRMLScene* scene) {
  const auto training = trainingLabelsOf(model, labels, scene);
  const auto unstoppable = std::make_shared<DetachedTasks>();
  return
      [training, unstoppable](const std::stop_token& stop) { return training->labels(stop, *unstoppable); };
}

} // namespace innergs::mrml
