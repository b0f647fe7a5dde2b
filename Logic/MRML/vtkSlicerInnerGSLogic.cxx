#include "vtkSlicerInnerGSLogic.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Motion/DynamicField.h"
#include "DynamicWork.h"
#include "GaussianModel.h"
#include "Geometry.h"
#include "IO/FilePath.h"
#include "LogicInternals.h"
#include "ModelReading.h"
#include "ModelWriting.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "Queries.h"
#include "SceneChoices.h"
#include "SegmentLearning.h"
#include "SequenceNodes.h"
#include "SliceTransforms.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSSegment.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSDynamicRequest.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLLinearTransformNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSegmentationNode.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>
#include <vtkMRMLSliceNode.h>
#include <vtkMRMLTransformNode.h>

#include <vtkCollection.h>
#include <vtkDoubleArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkIntArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPoints.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <filesystem>
#include <limits>

vtkStandardNewMacro(vtkSlicerInnerGSLogic);

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

namespace {

/// For other threads, which must not copy VTK's weak pointers.
template <class Object>
std::shared_ptr<vtkWeakPointer<Object>> weakly(Object* object) {
  return std::make_shared<vtkWeakPointer<Object>>(object);
}

/// For a thread other than the one that reports the exception.
std::exception_ptr thrownBy(const std::function<void()>& task) {
  try {
    task();
    return nullptr;
  } catch (...) {
    return std::current_exception();
  }
}

/// Of a node's dynamic model. Throws Error.
std::shared_ptr<const innergs::DynamicField> dynamicField(vtkMRMLInnerGSModelNode* model) {
  mrml::modelOf(model);
  if (!model->IsDynamic())
    throw Error(ErrorCode::InvalidArgument,
                "The model " + mrml::quoted(model) + " is not of a dynamic scan: choose one that is.");
  return model->GetDynamicModel()->GetField();
}

template <class Node>
Node* kept(const vtkSmartPointer<Node>& made) {
  return made && made->GetScene() ? made.Get() : nullptr;
}

/// A new sequence follows the model's parent transform through its proxy node only: it is refused.
void refuseParent(vtkMRMLInnerGSModelNode* model) {
  if (model->GetParentTransformNode())
    throw Error(ErrorCode::Geometry,
                "The model " + mrml::quoted(model) +
                    " is under a transform, under which a sequence cannot be put: remove "
                    "the transform first.");
}

} // namespace

//------------------------------------------------------------------------------

vtkSlicerInnerGSLogic::vtkSlicerInnerGSLogic() : Work(std::make_unique<Internals>(this)) {}

vtkSlicerInnerGSLogic::~vtkSlicerInnerGSLogic() = default;

void vtkSlicerInnerGSLogic::SetMRMLApplicationLogic(vtkMRMLApplicationLogic* application) {
  this->Superclass::SetMRMLApplicationLogic(application);
  this->Work->setApplication(vtkSlicerApplicationLogic::SafeDownCast(application));
}

void vtkSlicerInnerGSLogic::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Jobs: " << this->GetNumberOfJobs() << "\n";
  os << indent << "LastError: " << this->Work->lastError.sentence << "\n";
}

std::string vtkSlicerInnerGSLogic::GetVersion() {
  return INNERGS_VERSION;
}

void vtkSlicerInnerGSLogic::RegisterNodes() {
  vtkMRMLScene* scene = this->GetMRMLScene();
  if (!scene) return;
  scene->RegisterNodeClass(vtkSmartPointer<vtkMRMLInnerGSParameterNode>::New());
  scene->RegisterNodeClass(vtkSmartPointer<vtkMRMLInnerGSModelNode>::New());
  scene->RegisterNodeClass(vtkSmartPointer<vtkMRMLInnerGSModelStorageNode>::New());
  if (!scene->IsNodeClassRegistered("vtkMRMLSequenceBrowserNode")) // without Slicer's Sequences module
    scene->RegisterNodeClass(vtkSmartPointer<vtkMRMLSequenceBrowserNode>::New());
}

void vtkSlicerInnerGSLogic::SetMRMLSceneInternal(vtkMRMLScene* scene) {
  if (this->GetMRMLScene() && scene != this->GetMRMLScene()) this->OnMRMLSceneStartClose();
  vtkNew<vtkIntArray> events;
  events->InsertNextValue(vtkMRMLScene::StartCloseEvent);
  events->InsertNextValue(vtkMRMLScene::EndImportEvent);
  events->InsertNextValue(vtkMRMLScene::NodeRemovedEvent);
  this->SetAndObserveMRMLSceneEventsInternal(scene, events);
}

void vtkSlicerInnerGSLogic::OnMRMLSceneStartClose() {
  this->StopFollowing();
  for (const auto& task : this->Work->queue.tasks())
    task->discard = task->keep = true;
  this->Work->delivery.discard();
  this->Cancel();
}

void vtkSlicerInnerGSLogic::OnMRMLSceneEndImport() {
  mrml::restoreBackgrounds(this->GetMRMLScene());
}

void vtkSlicerInnerGSLogic::OnMRMLSceneNodeRemoved(vtkMRMLNode* node) {
  this->Work->stopFollowing([&](const auto& follower) { return follower.concerns(node); });
  for (const auto& task : this->Work->queue.tasks())
    if (task->parameters.Get() == node || (task->work && task->model.Get() == node)) {
      task->discard = true;
      task->keep = task->parameters.Get() == node;
      this->Work->queue.cancel(task);
    }
  mrml::leaveHierarchy(node, this->GetMRMLScene());
}

//------------------------------------------------------------------------------

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartReconstruction(vtkMRMLInnerGSParameterNode* parameters,
                                                                bool copyVoxels) {
  return this->Work->start([&] {
    return mrml::prepare(parameters, this->GetMRMLScene(), this->Work->thicknessOf(),
                         copyVoxels || this->GetNumberOfJobs() > 0);
  });
}

bool vtkSlicerInnerGSLogic::Reconstruct(vtkMRMLInnerGSParameterNode* parameters) {
  return this->Work->finishes(this->StartReconstruction(parameters));
}

void vtkSlicerInnerGSLogic::Cancel(vtkSlicerInnerGSJob* job) {
  this->RequestCancel(job);
  this->WaitForJob(job);
}

void vtkSlicerInnerGSLogic::RequestCancel(vtkSlicerInnerGSJob* job) {
  for (const auto& task : this->Work->queue.tasks())
    if (!job || task->job == job) this->Work->queue.cancel(task);
}

bool vtkSlicerInnerGSLogic::IsRunning() {
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive = this; // an observer may let go of it
  this->ProcessPendingEvents();
  return this->GetNumberOfJobs() > 0;
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::GetCurrentJob() {
  const auto tasks = this->Work->queue.tasks();
  return tasks.empty() ? nullptr : tasks.front()->job.Get();
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::GetLastJob() {
  return this->Work->lastJob;
}

int vtkSlicerInnerGSLogic::GetNumberOfJobs() {
  return static_cast<int>(this->Work->queue.tasks().size());
}

bool vtkSlicerInnerGSLogic::WaitForJob(vtkSlicerInnerGSJob* job, double seconds) {
  using Clock = std::chrono::steady_clock;
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive = this;
  const auto start = Clock::now();
  const auto waiting = [&] { return job ? this->Work->taskOf(job) != nullptr : this->GetNumberOfJobs() > 0; };
  while (waiting()) {
    const double left =
        seconds < 0 ? 0.2 : seconds - std::chrono::duration<double>(Clock::now() - start).count();
    if (left <= 0) break;
    if (this->Work->queue.wait(std::min(left, 0.2)) && this->ProcessPendingEvents() == 0) break;
  }
  return !waiting();
}

int vtkSlicerInnerGSLogic::ProcessPendingEvents() {
  if (std::this_thread::get_id() != this->Work->mainThread) return 0;
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive = this; // an observer may let go of it
  while (const auto plane = this->Work->fine.fetch())
    if (const auto follower = plane->follower.lock()) this->Work->showFine(follower, *plane);
  int count = 0;
  // One round: a worker faster than the observers must not keep the main thread here.
  const int limit = 4 * this->GetNumberOfJobs(); // started, progress, preview, done
  for (; count < limit; ++count) {
    std::optional<mrml::JobUpdate> update = this->Work->queue.fetch();
    if (!update) break;
    this->Work->delivery.deliver(*update);
  }
  return count;
}

std::string vtkSlicerInnerGSLogic::GetLastError() {
  return this->Work->lastError.sentence;
}

int vtkSlicerInnerGSLogic::GetLastErrorCode() {
  return this->Work->lastError.sentence.empty()
             ? 0
             : vtkInnerGSAlgorithm::ToErrorNumber(this->Work->lastError.code);
}

std::string vtkSlicerInnerGSLogic::CheckParameters(vtkMRMLInnerGSParameterNode* parameters) {
  return innergs::sentenceOf([&] {
    mrml::check(parameters, this->GetMRMLScene(), this->Work->thicknessOf());
    if (this->GetNumberOfJobs() > 0) return; // memory in use now is free again when its turn comes
    if (const std::string refusal = this->Work->outlineOf(parameters).memory().refusal; !refusal.empty())
      throw Error(ErrorCode::Memory, refusal);
  });
}

vtkTypeInt64 vtkSlicerInnerGSLogic::EstimateMemory(vtkMRMLInnerGSParameterNode* parameters) {
  try {
    return this->Work->outlineOf(parameters).memory().bytes;
  } catch (const std::exception&) {
    return 0;
  }
}

double vtkSlicerInnerGSLogic::EstimateSeconds(vtkMRMLInnerGSParameterNode* parameters) {
  try {
    return this->Work->outlineOf(parameters).forecast().seconds;
  } catch (const std::exception&) {
    return 0;
  }
}

std::function<innergs::JobForecast()>
vtkSlicerInnerGSLogic::EstimateLater(vtkMRMLInnerGSParameterNode* parameters, std::string* key) {
  try {
    const auto outline = std::make_shared<innergs::JobOutline>(this->Work->outlineOf(parameters));
    if (key) *key = outline->key();
    return [outline] { return outline->forecast(); };
  } catch (const std::exception&) {
    return {};
  }
}

std::string vtkSlicerInnerGSLogic::DescribeDevice(vtkMRMLInnerGSParameterNode* parameters) {
  return parameters ? mrml::describeDevice(parameters) : "";
}

void vtkSlicerInnerGSLogic::SetRecoveryFolder(const std::string& folder) {
  this->Work->recoveryFolder = folder;
}

std::string vtkSlicerInnerGSLogic::GetRecoveryFolder() {
  if (!this->Work->recoveryFolder.empty()) return this->Work->recoveryFolder;
  vtkMRMLApplicationLogic* application = this->GetMRMLApplicationLogic();
  const char* temporary = application ? application->GetTemporaryPath() : nullptr;
  if (temporary && *temporary) return std::string(temporary) + "/InnerGS-recovery";
  std::error_code failed;
  const std::filesystem::path folder = std::filesystem::temp_directory_path(failed);
  return innergs::utf8((failed ? std::filesystem::path(".") : folder) / "InnerGS-recovery");
}

double vtkSlicerInnerGSLogic::GetDicomSliceThickness(vtkMRMLVolumeNode* volume) {
  return this->Work->thicknessOf()(volume);
}

int vtkSlicerInnerGSLogic::GetNumberOfInterleavedPasses(vtkMRMLVolumeNode* volume) {
  return this->Work->passesOf(volume);
}

void vtkSlicerInnerGSLogic::SetDicomLookup(DicomLookup lookup) {
  this->Work->dicom = std::move(lookup);
}

//------------------------------------------------------------------------------
// Queries of models, and their files.

bool vtkSlicerInnerGSLogic::CreateSliceTransforms(vtkMRMLTableNode* slices, vtkCollection* transforms) {
  return this->Work->guard([&] {
    for (const auto& made : mrml::makeSliceTransforms(slices))
      if (transforms) transforms->AddItem(made);
  });
}

double vtkSlicerInnerGSLogic::GetValueAtRAS(vtkMRMLInnerGSModelNode* model, double r, double a, double s) {
  vtkNew<vtkPoints> point;
  point->SetDataTypeToDouble();
  point->InsertNextPoint(r, a, s);
  vtkNew<vtkFloatArray> value;
  return this->GetValuesAtRAS(model, point, value) ? static_cast<double>(value->GetValue(0))
                                                   : std::numeric_limits<double>::quiet_NaN();
}

bool vtkSlicerInnerGSLogic::GetValuesAtRAS(vtkMRMLInnerGSModelNode* model, vtkPoints* points,
                                           vtkFloatArray* values) {
  const bool done = this->Work->guard([&] { mrml::evaluate(model, points, values); });
  if (!done && values) values->Initialize();
  return done;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryPlane(vtkMRMLInnerGSModelNode* model,
                                                           vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                           double spacing, vtkMRMLScalarVolumeNode* output) {
  return this->Work->answer(output, [&] {
    return mrml::queryPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing, output);
  });
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryUncertaintyPlane(vtkMRMLInnerGSModelNode* model,
                                                                      vtkMatrix4x4* planeToRAS, int columns,
                                                                      int rows, double spacing,
                                                                      vtkMRMLScalarVolumeNode* output) {
  return this->Work->answer(output, [&] {
    return mrml::queryUncertaintyPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing,
                                       output);
  });
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Resample(vtkMRMLInnerGSModelNode* model, double spacing,
                                                         vtkMRMLScalarVolumeNode* output) {
  return this->Work->answer(output,
                            [&] { return mrml::resample(this->GetMRMLScene(), model, spacing, output); });
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ResampleLike(vtkMRMLInnerGSModelNode* model,
                                                             vtkMRMLVolumeNode* reference,
                                                             vtkMRMLScalarVolumeNode* output) {
  return this->Work->answer(
      output, [&] { return mrml::resampleLike(this->GetMRMLScene(), model, reference, output); });
}

//------------------------------------------------------------------------------

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::FollowSlice(vtkMRMLInnerGSModelNode* model,
                                                            vtkMRMLSliceNode* slice,
                                                            vtkMRMLScalarVolumeNode* output) {
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive =
      this; // an observer may release it, or remove the nodes
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> keptModel = model;
  const vtkSmartPointer<vtkMRMLSliceNode> keptSlice = slice;
  vtkSmartPointer<vtkMRMLScalarVolumeNode> shown;
  const bool done = this->Work->guard([&] {
    mrml::modelOf(model);
    if (!slice) throw Error(ErrorCode::InvalidArgument, "There is no slice view to follow: choose one.");
    const auto follower = std::make_shared<mrml::SliceFollower>(
        model, slice, this->MaximumFollowPixels,
        [this](const innergs::Failure& failure) { this->Work->fail(failure); },
        [this](const std::shared_ptr<mrml::SliceFollower>& coarse, int revision,
               innergs::PlaneRequest request) {
          this->Work->fine.request(coarse, revision, std::move(request));
        });
    follower->query(); // throws before anything is changed
    shown = mrml::volumeFor(this->GetMRMLScene(), output, model, " slice");
    if (!mrml::kept(shown, output) || (this->GetMRMLScene() && !model->GetScene())) return;
    this->StopFollowing(shown);
    mrml::setProvenance(shown, model);
    follower->setOutput(shown);
    this->Work->followers.push_back(follower);
    follower->show();
  });
  return done && this->IsFollowing(shown) ? shown.Get() : nullptr;
}

void vtkSlicerInnerGSLogic::StopFollowing(vtkMRMLScalarVolumeNode* output) {
  this->Work->stopFollowing([&](const auto& follower) { return !output || follower.output() == output; });
}

bool vtkSlicerInnerGSLogic::IsFollowing(vtkMRMLScalarVolumeNode* output) {
  for (const auto& follower : this->Work->followers)
    if (output && follower->output() == output) return true;
  return false;
}

vtkMRMLModelNode* vtkSlicerInnerGSLogic::CreateGaussianModel(vtkMRMLInnerGSModelNode* model, int maximum,
                                                             vtkMRMLModelNode* output) {
  vtkSmartPointer<vtkMRMLModelNode> made;
  this->Work->guard([&] { made = mrml::makeGaussianModel(this->GetMRMLScene(), model, maximum, output); });
  return mrml::kept(made, output);
}

vtkMRMLInnerGSModelNode* vtkSlicerInnerGSLogic::LoadModel(const std::string& fileName) {
  vtkMRMLInnerGSModelNode* result = nullptr;
  this->Work->guard([&] {
    mrml::ModelReading reading(fileName);
    reading.read();
    result = reading.addTo(this->GetMRMLScene());
  });
  return result;
}

bool vtkSlicerInnerGSLogic::SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  return this->Work->guard([&] {
    mrml::ModelWriting writing(model, fileName);
    writing.write();
    writing.note();
  });
}

std::function<std::function<vtkMRMLInnerGSModelNode*()>()>
vtkSlicerInnerGSLogic::LoadModelLater(const std::string& fileName) {
  const auto reading = std::make_shared<mrml::ModelReading>(fileName);
  const std::shared_ptr<vtkWeakPointer<vtkSlicerInnerGSLogic>> self = weakly(this);
  return [self, reading] {
    const std::exception_ptr problem = thrownBy([&] { reading->read(); });
    return [self, reading, problem]() -> vtkMRMLInnerGSModelNode* {
      vtkMRMLInnerGSModelNode* result = nullptr;
      if (!*self) return nullptr;
      (*self)->Work->guard([&] {
        if (problem) std::rethrow_exception(problem);
        result = reading->addTo((*self)->GetMRMLScene());
      });
      return result;
    };
  };
}

std::function<std::function<bool()>()> vtkSlicerInnerGSLogic::SaveModelLater(vtkMRMLInnerGSModelNode* model,
                                                                             const std::string& fileName) {
  std::shared_ptr<mrml::ModelWriting> writing;
  const std::exception_ptr refused =
      thrownBy([&] { writing = std::make_shared<mrml::ModelWriting>(model, fileName); });
  const std::shared_ptr<vtkWeakPointer<vtkSlicerInnerGSLogic>> self = weakly(this);
  return [self, writing, refused] {
    const std::exception_ptr problem = refused ? refused : thrownBy([&] { writing->write(); });
    return [self, writing, problem] {
      return *self && (*self)->Work->guard([&] {
        if (problem) std::rethrow_exception(problem);
        writing->note();
      });
    };
  };
}

//------------------------------------------------------------------------------
// Segments found by text.

static_assert(static_cast<int>(innergs::AnswerKind::Found) == vtkInnerGSSegment::Found &&
              static_cast<int>(innergs::AnswerKind::Similar) == vtkInnerGSSegment::Similar);

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearning(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels,
                                                          bool sparse) {
  return this->Work->start(
      [&] { return mrml::prepareLearning(model, labels, sparse, this->GetMRMLScene()); });
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearningFromFeatures(vtkMRMLInnerGSModelNode* model,
                                                                      vtkMRMLVolumeNode* features,
                                                                      const std::string& textsFile) {
  return this->Work->start(
      [&] { return mrml::prepareFeatureLearning(model, features, textsFile, this->GetMRMLScene()); });
}

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartLearningFromNetwork(vtkMRMLInnerGSModelNode* model,
                                                                     const std::string& networkFile,
                                                                     vtkStringArray* names,
                                                                     const std::string& textsFile, double low,
                                                                     double high, double spacing) {
  return this->Work->start([&] {
    mrml::NetworkTeacher network{networkFile, {}, textsFile, {low, high}, spacing};
    for (vtkIdType n = 0; names && n < names->GetNumberOfValues(); ++n)
      network.names.push_back(names->GetValue(n));
    return mrml::prepareNetworkLearning(model, network, this->GetMRMLScene());
  });
}

bool vtkSlicerInnerGSLogic::LearnSegments(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels, bool sparse) {
  return this->Work->finishes(this->StartLearning(model, labels, sparse));
}

std::function<innergs::NamedLabels(const std::stop_token&)>
vtkSlicerInnerGSLogic::LabelsLater(vtkMRMLInnerGSModelNode* model, vtkMRMLNode* labels) {
  std::function<innergs::NamedLabels(const std::stop_token&)> later;
  this->Work->guard([&] { later = mrml::labelsLater(model, labels, this->GetMRMLScene()); });
  return later;
}

int vtkSlicerInnerGSLogic::FindByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                      vtkTable* candidates) {
  int kind = -1;
  if (candidates) candidates->Initialize();
  this->Work->guard([&] {
    const innergs::SegmentAnswer answer = this->Work->segments.ask(model, text, 0);
    const innergs::SegmentFinder& finder = this->Work->segments.finder(model);
    kind = static_cast<int>(answer.kind);
    if (!candidates) return;
    vtkNew<vtkStringArray> names;
    vtkNew<vtkDoubleArray> scores;
    vtkNew<vtkIntArray> leading;
    names->SetName("Name");
    scores->SetName("Score");
    leading->SetName("Leading");
    for (std::size_t n = 0; n < answer.candidates.size(); ++n) {
      names->InsertNextValue(finder.nameOf(answer.candidates[n]));
      scores->InsertNextValue(answer.candidates[n].score);
      leading->InsertNextValue(n < answer.leading);
    }
    for (vtkAbstractArray* column :
         {static_cast<vtkAbstractArray*>(names), static_cast<vtkAbstractArray*>(scores),
          static_cast<vtkAbstractArray*>(leading)})
      candidates->AddColumn(column);
  });
  return kind;
}

std::string vtkSlicerInnerGSLogic::GetLastAnswer() {
  return this->Work->segments.answer;
}

vtkMRMLSegmentationNode*
vtkSlicerInnerGSLogic::SegmentByText(vtkMRMLInnerGSModelNode* model, const std::string& text,
                                     vtkMRMLSegmentationNode* output, double threshold, bool largestOnly,
                                     double minimumSize, double smoothing, double spacing) {
  vtkSmartPointer<vtkMRMLSegmentationNode> made;
  this->Work->guard([&] {
    made = mrml::addSegments(
        this->GetMRMLScene(), model,
        this->Work->segments.made(model, text, spacing, {threshold, smoothing, largestOnly, minimumSize}),
        output);
  });
  return kept(made);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ScoreByText(vtkMRMLInnerGSModelNode* model,
                                                            const std::string& text,
                                                            vtkMRMLScalarVolumeNode* output, double spacing) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made =
        mrml::addScore(this->GetMRMLScene(), model, this->Work->segments.made(model, text, spacing), output);
  });
  return kept(made);
}

vtkMRMLSegmentationNode* vtkSlicerInnerGSLogic::AddSegments(vtkMRMLInnerGSModelNode* model,
                                                            const innergs::MadeSegments& segments,
                                                            vtkMRMLSegmentationNode* output) {
  vtkSmartPointer<vtkMRMLSegmentationNode> made;
  this->Work->guard([&] {
    mrml::modelOf(model);
    made = mrml::addSegments(this->GetMRMLScene(), model, segments, output);
  });
  return kept(made);
}

//------------------------------------------------------------------------------
// Dynamic scans.

vtkSlicerInnerGSJob*
vtkSlicerInnerGSLogic::StartDynamicReconstruction(vtkSlicerInnerGSDynamicRequest* request) {
  return this->Work->start([&] {
    if (!this->GetMRMLScene())
      throw Error(ErrorCode::InvalidArgument, "The logic has no scene to put the result into: set one.");
    auto task = std::make_shared<mrml::Task>();
    task->dynamic = std::make_shared<mrml::DynamicWork>(request);
    task->scene = this->GetMRMLScene();
    task->recovered = task->dynamic->about();
    return task;
  });
}

bool vtkSlicerInnerGSLogic::ReconstructDynamic(vtkSlicerInnerGSDynamicRequest* request) {
  return this->Work->finishes(this->StartDynamicReconstruction(request));
}

std::string vtkSlicerInnerGSLogic::CheckDynamicRequest(vtkSlicerInnerGSDynamicRequest* request) {
  return innergs::sentenceOf([&] {
    if (!request) throw Error(ErrorCode::InvalidArgument, "There is no request: give one.");
    const innergs::TimeSeries series = mrml::seriesOf(request->GetSeries(), request->GetInterval(), false);
    mrml::sliceTimingOf(request, series.geometry);
    mrml::framesWanted(request->GetTimes(), request->GetRate(), series.times);
  });
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::PreviewFrame(vtkSlicerInnerGSJob* job, double seconds,
                                                             vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made = output;
  const bool done = this->Work->guard([&] {
    if (!job || !job->GetPreviewModel())
      throw Error(ErrorCode::InvalidArgument,
                  "There is no preview of a dynamic scan: wait for a JobPreviewEvent of its job.");
    if (!std::isfinite(seconds))
      throw Error(ErrorCode::InvalidArgument, "The time to show must be finite: give it in seconds.");
    if (!this->GetMRMLScene())
      throw Error(ErrorCode::InvalidArgument, "The logic has no scene to put the result into: set one.");
    const auto field = job->GetPreviewModel()->GetField();
    const auto frame = mrml::renderFrames(*field, {seconds}).front();
    if (!made)
      made = vtkMRMLScalarVolumeNode::SafeDownCast(
          mrml::addNode(this->GetMRMLScene(), "vtkMRMLScalarVolumeNode", "InnerGS preview"));
    vtkNew<vtkMatrix4x4> ijkToRAS;
    innergs::vtk::toMatrix(field->canonical.region(), ijkToRAS);
    if (made) mrml::setVolume(made, frame, ijkToRAS);
  });
  return done ? kept(made) : nullptr;
}

vtkMRMLSequenceNode* vtkSlicerInnerGSLogic::CreateFrames(vtkMRMLInnerGSModelNode* model,
                                                         vtkDoubleArray* times, vtkMRMLSequenceNode* output) {
  vtkSmartPointer<vtkMRMLSequenceNode> made = output;
  const bool done = this->Work->guard([&] {
    const vtkSmartPointer<vtkMRMLInnerGSModelNode> alive = model;
    const auto field = dynamicField(model);
    refuseParent(model);
    const std::vector<double> wanted = mrml::framesWanted(times, 0, field->times);
    const auto frames = mrml::renderFrames(*field, wanted);
    if (!made)
      made = mrml::addSequence(this->GetMRMLScene(), std::string(model->GetName()) + " frames", model);
    mrml::setProvenance(made, model);
    mrml::fillFrames(made, *field, wanted, frames);
    if (made->GetScene()) mrml::browse(made, nullptr);
  });
  return done ? kept(made) : nullptr;
}

vtkMRMLSequenceNode* vtkSlicerInnerGSLogic::CreateMotion(vtkMRMLInnerGSModelNode* model,
                                                         vtkDoubleArray* times, double from,
                                                         vtkMRMLSequenceNode* output) {
  vtkSmartPointer<vtkMRMLSequenceNode> made = output;
  const bool done = this->Work->guard([&] {
    const vtkSmartPointer<vtkMRMLInnerGSModelNode> alive = model;
    const auto field = dynamicField(model);
    refuseParent(model);
    if (field->kind == innergs::DynamicKind::Intensity)
      throw Error(ErrorCode::InvalidArgument,
                  "The Gaussians of " + mrml::quoted(model) +
                      " stay in place and change their intensity, so there is no motion: reconstruct with "
                      "Kind = Motion.");
    const std::vector<double> wanted = mrml::framesWanted(times, 0, field->times);
    if (!made)
      made = mrml::addSequence(this->GetMRMLScene(), std::string(model->GetName()) + " motion", model);
    mrml::setProvenance(made, model);
    mrml::fillMotion(made, *field, wanted, from);
    if (made->GetScene()) mrml::browse(made, nullptr);
  });
  return done ? kept(made) : nullptr;
}
