#include "vtkSlicerInnerGSLogic.h"

#include "Core/Error.h"
#include "JobQueue.h"
#include "NodeGeometry.h"
#include "Outputs.h"
#include "Queries.h"
#include "SliceFollower.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSPointQuery.h"
#include "vtkInnerGSResample.h"
#include "vtkInnerGSToPolyData.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSliceNode.h>
#include <vtkMRMLTableNode.h>
#include <vtkSlicerApplicationLogic.h>

#include <vtkCallbackCommand.h>
#include <vtkFloatArray.h>
#include <vtkObjectFactory.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <atomic>
#include <chrono>
#include <limits>

vtkStandardNewMacro(vtkSlicerInnerGSLogic);

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

struct vtkSlicerInnerGSLogic::Internals {
  vtkSlicerInnerGSLogic* logic;
  std::thread::id mainThread = std::this_thread::get_id();
  std::string lastError;
  vtkSmartPointer<vtkSlicerInnerGSJob> lastJob;
  std::vector<std::unique_ptr<mrml::SliceFollower>> followers;

  // The application's event loop modifies the bell on the main thread when the worker asks for it.
  vtkNew<vtkObject> bell;
  vtkNew<vtkCallbackCommand> onBell;
  std::atomic<vtkSlicerApplicationLogic*> application = nullptr;
  std::atomic<bool> delivered = false; // an application took the worker's last call

  mrml::JobQueue queue; // last: its worker ends before the rest goes

  explicit Internals(vtkSlicerInnerGSLogic* owner) : logic(owner), queue([this] { this->ring(); }) {
    onBell->SetClientData(owner);
    onBell->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
      static_cast<vtkSlicerInnerGSLogic*>(self)->ProcessPendingEvents();
    });
    bell->AddObserver(vtkCommand::ModifiedEvent, onBell);
  }
  ~Internals() { bell->RemoveObserver(onBell); }

  void ring() { // on the worker
    vtkSlicerApplicationLogic* app = application;
    delivered = app && app->RequestModified(bell) != 0;
  }

  /// Runs the task; what it throws becomes an ErrorEvent and the last error. False then.
  bool guard(const std::function<void()>& task);
  void fail(const std::string& sentence);
  std::shared_ptr<mrml::Task> taskOf(vtkSlicerInnerGSJob* job) const;
  void deliver(mrml::Mail& mail);
  void finish(mrml::Task& task);
  void follow(vtkMRMLInnerGSModelNode* model, vtkMRMLSliceNode* slice, vtkMRMLScalarVolumeNode* output);

  /// The output, or a new volume node; throws when it is of another scene.
  vtkMRMLScalarVolumeNode* volumeFor(vtkMRMLScalarVolumeNode* output, vtkMRMLInnerGSModelNode* model,
                                     const char* suffix);
};

bool vtkSlicerInnerGSLogic::Internals::guard(const std::function<void()>& task) {
  lastError.clear();
  try {
    if (std::this_thread::get_id() != mainThread)
      throw Error(
          ErrorCode::InvalidArgument,
          "The InnerGS logic was called from another thread than the one that made it: call it from the "
          "main thread.");
    task();
    return true;
  } catch (const std::bad_alloc&) {
    fail("The memory is not enough: choose a smaller region, a coarser output or fewer Gaussians.");
  } catch (const std::exception& error) {
    fail(error.what());
  }
  return false;
}

void vtkSlicerInnerGSLogic::Internals::fail(const std::string& sentence) {
  lastError = sentence;
  vtkErrorWithObjectMacro(logic, << sentence);
}

std::shared_ptr<mrml::Task> vtkSlicerInnerGSLogic::Internals::taskOf(vtkSlicerInnerGSJob* job) const {
  for (const auto& task : queue.tasks())
    if (task->job == job) return task;
  return nullptr;
}

void vtkSlicerInnerGSLogic::Internals::deliver(mrml::Mail& mail) {
  const std::shared_ptr<mrml::Task> task = mail.task;
  vtkSlicerInnerGSJob* job = task->job;
  if (mail.started && job->State == vtkSlicerInnerGSJob::Queued && !task->discard) {
    job->State = vtkSlicerInnerGSJob::Running;
    logic->InvokeEvent(JobStartedEvent, job);
  }
  if (mail.progress && !task->discard) {
    const auto& p = *mail.progress;
    job->Phase = p.phase;
    job->Progress = p.fraction;
    job->Loss = p.loss;
    job->TrainingPSNR = p.trainingPsnr;
    job->HeldOutPSNR = p.heldOutPsnr;
    job->ElapsedSeconds = p.elapsed;
    job->RemainingSeconds = p.remaining;
    job->CurrentIteration = p.iteration;
    job->TotalIterations = p.iterations;
    job->NumberOfGaussians = p.gaussians;
    logic->InvokeEvent(JobProgressEvent, job);
  }
  if (mail.preview && !task->discard) {
    job->Preview = mail.preview;
    job->PreviewIJKToRAS = mail.previewToRAS;
    logic->InvokeEvent(JobPreviewEvent, job);
  }
  if (mail.done) finish(*task);
}

void vtkSlicerInnerGSLogic::Internals::finish(mrml::Task& task) {
  vtkSlicerInnerGSJob* job = task.job;
  job->RemainingSeconds = 0;
  vtkMRMLScene* scene = logic->GetMRMLScene();
  if (task.discard || task.cancelled || !scene || scene != task.scene.Get() || scene->IsClosing()) {
    job->State = vtkSlicerInnerGSJob::Cancelled;
    logic->InvokeEvent(JobCancelledEvent, job);
    return;
  }
  std::string error = task.error;
  if (error.empty()) {
    try {
      job->UsedSettings = task.filter->GetUsedSettings();
      job->TrainingPSNR = task.filter->GetTrainingPSNR();
      job->HeldOutPSNR = task.filter->GetHeldOutPSNR();
      for (int n = 0; n < task.filter->GetNumberOfWarnings(); ++n)
        job->Warnings.push_back(task.filter->GetWarning(n));
      if (!task.qualityError.empty())
        job->Warnings.push_back("The quality could not be judged. " + task.qualityError);
      vtkMRMLScalarVolumeNode* volume = nullptr;
      vtkMRMLInnerGSModelNode* model = nullptr;
      vtkMRMLTableNode* table = nullptr;
      mrml::makeOutputs(task, scene, volume, model, table);
      if (!volume || !model)
        job->Warnings.push_back(
            "An output node was deleted during the reconstruction: what was meant for it is "
            "lost.");
      job->VolumeNode = volume;
      job->ModelNode = model;
      job->TableNode = table;
      if (task.parameters && task.parameters->GetScene() == scene) {
        using Parameters = vtkMRMLInnerGSParameterNode;
        const auto refer = [&](const char* role, vtkMRMLNode* node) {
          task.parameters->SetNodeReferenceID(role, node ? node->GetID() : nullptr);
        };
        MRMLNodeModifyBlocker blocker(task.parameters);
        refer(Parameters::GetResultVolumeReferenceRole(), volume);
        refer(Parameters::GetResultModelReferenceRole(), model);
        refer(Parameters::GetResultTableReferenceRole(), table);
      }
      job->Progress = 1;
      job->Phase = "Done";
      job->State = vtkSlicerInnerGSJob::Finished;
    } catch (const std::exception& exception) {
      error = exception.what();
    }
  }
  task.filter = nullptr; // with its volumes
  if (error.empty()) {
    logic->InvokeEvent(JobFinishedEvent, job);
    return;
  }
  job->State = vtkSlicerInnerGSJob::Failed;
  job->ErrorMessage = error;
  fail(error);
  logic->InvokeEvent(JobFailedEvent, job);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Internals::volumeFor(vtkMRMLScalarVolumeNode* output,
                                                                     vtkMRMLInnerGSModelNode* model,
                                                                     const char* suffix) {
  if (output) return output;
  vtkMRMLScene* scene = logic->GetMRMLScene();
  if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a volume to: set one.");
  const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + suffix;
  output = vtkMRMLScalarVolumeNode::SafeDownCast(mrml::addNode(scene, "vtkMRMLScalarVolumeNode", name));
  mrml::placeBeside(output, model);
  return output;
}

//------------------------------------------------------------------------------

vtkSlicerInnerGSLogic::vtkSlicerInnerGSLogic() : Work(std::make_unique<Internals>(this)) {}

vtkSlicerInnerGSLogic::~vtkSlicerInnerGSLogic() {
  for (const auto& task : this->Work->queue.tasks())
    task->job->State = vtkSlicerInnerGSJob::Cancelled;
}

void vtkSlicerInnerGSLogic::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Jobs: " << this->GetNumberOfJobs() << "\n";
  os << indent << "LastError: " << this->Work->lastError << "\n";
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
}

void vtkSlicerInnerGSLogic::SetMRMLSceneInternal(vtkMRMLScene* scene) {
  if (this->GetMRMLScene() && scene != this->GetMRMLScene()) this->OnMRMLSceneStartClose();
  vtkNew<vtkIntArray> events;
  events->InsertNextValue(vtkMRMLScene::StartCloseEvent);
  events->InsertNextValue(vtkMRMLScene::NodeRemovedEvent);
  this->SetAndObserveMRMLSceneEventsInternal(scene, events);
}

void vtkSlicerInnerGSLogic::OnMRMLSceneStartClose() {
  this->StopFollowing();
  for (const auto& task : this->Work->queue.tasks())
    task->discard = true;
  this->Cancel();
}

void vtkSlicerInnerGSLogic::OnMRMLSceneNodeRemoved(vtkMRMLNode* node) {
  std::erase_if(this->Work->followers, [&](const auto& follower) { return follower->concerns(node); });
  for (const auto& task : this->Work->queue.tasks())
    if (task->parameters.Get() == node) {
      task->discard = true;
      this->Work->queue.cancel(task);
    }
}

//------------------------------------------------------------------------------

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartReconstruction(vtkMRMLInnerGSParameterNode* parameters) {
  Internals& work = *this->Work;
  const bool started = work.guard([&] {
    std::shared_ptr<mrml::Task> task = mrml::prepare(parameters, this->GetMRMLScene());
    task->job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    task->job->ParameterNode = parameters;
    work.lastJob = task->job;
    work.application = this->GetApplicationLogic();
    work.queue.submit(std::move(task));
  });
  return started ? work.lastJob.Get() : nullptr;
}

bool vtkSlicerInnerGSLogic::Reconstruct(vtkMRMLInnerGSParameterNode* parameters) {
  const vtkSmartPointer<vtkSlicerInnerGSJob> job = this->StartReconstruction(parameters);
  if (!job) return false;
  this->WaitForJob(job);
  return job->State == vtkSlicerInnerGSJob::Finished;
}

void vtkSlicerInnerGSLogic::Cancel(vtkSlicerInnerGSJob* job) {
  for (const auto& task : this->Work->queue.tasks())
    if (!job || task->job == job) this->Work->queue.cancel(task);
  this->WaitForJob(job);
}

bool vtkSlicerInnerGSLogic::IsRunning() {
  if (!this->Work->delivered && std::this_thread::get_id() == this->Work->mainThread)
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
  int count = 0;
  // One round: a worker that tells faster than observers listen must not keep the main thread here.
  for (const auto limit = this->Work->queue.tasks().size() + 1; count < static_cast<int>(limit); ++count) {
    std::optional<mrml::Mail> mail = this->Work->queue.fetch();
    if (!mail) break;
    this->Work->deliver(*mail);
  }
  return count;
}

std::string vtkSlicerInnerGSLogic::GetLastError() {
  return this->Work->lastError;
}

std::string vtkSlicerInnerGSLogic::CheckParameters(vtkMRMLInnerGSParameterNode* parameters) {
  try {
    mrml::check(parameters, this->GetMRMLScene());
    return "";
  } catch (const std::exception& error) {
    return error.what();
  }
}

vtkTypeInt64 vtkSlicerInnerGSLogic::EstimateMemory(vtkMRMLInnerGSParameterNode* parameters) {
  try {
    return mrml::check(parameters, this->GetMRMLScene())->EstimateMemory();
  } catch (const std::exception&) {
    return 0;
  }
}

//------------------------------------------------------------------------------

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
  const bool done = this->Work->guard([&] {
    if (!points || !values)
      throw Error(ErrorCode::InvalidArgument, "There are no points to evaluate, or no array for the values.");
    vtkNew<vtkInnerGSPointQuery> query;
    query->SetModel(mrml::modelOf(model));
    vtkNew<vtkMatrix4x4> toModel;
    mrml::fromWorld(model, toModel);
    vtkNew<vtkPoints> local;
    local->SetDataTypeToDouble();
    local->SetNumberOfPoints(points->GetNumberOfPoints());
    for (vtkIdType n = 0; n < points->GetNumberOfPoints(); ++n) {
      double at[4] = {0, 0, 0, 1};
      points->GetPoint(n, at);
      toModel->MultiplyPoint(at, at);
      local->SetPoint(n, at);
    }
    vtkNew<vtkCallbackCommand> quiet;
    query->AddObserver(vtkCommand::ErrorEvent, quiet);
    if (!query->Evaluate(local, values)) throw Error(ErrorCode::InvalidArgument, query->GetErrorMessage());
  });
  if (!done && values) values->Initialize();
  return done;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryPlane(vtkMRMLInnerGSModelNode* model,
                                                           vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                           double spacing, vtkMRMLScalarVolumeNode* output) {
  const bool done = this->Work->guard([&] {
    if (!planeToRAS)
      throw Error(ErrorCode::InvalidArgument, "There is no matrix that places the plane: give one.");
    if (columns < 1 || rows < 1 || !(spacing > 0))
      throw Error(ErrorCode::InvalidArgument,
                  "A plane needs at least one pixel a side and a spacing above 0 mm.");
    vtkNew<vtkInnerGSPlaneQuery> query;
    query->SetModel(mrml::modelOf(model));
    vtkNew<vtkMatrix4x4> toModel, plane, ijkToWorld;
    mrml::fromWorld(model, toModel);
    vtkMatrix4x4::Multiply4x4(toModel, planeToRAS, plane);
    query->SetPlaneToRASMatrix(plane);
    query->SetDimensions(columns, rows);
    query->SetSpacing(spacing, spacing);
    query->GeometryInImageOff();
    mrml::run(query);
    toModel->Invert();
    vtkMatrix4x4::Multiply4x4(toModel, query->GetOutputIJKToRASMatrix(), ijkToWorld);
    output = this->Work->volumeFor(output, model, " plane");
    mrml::setVolume(output, query->GetOutput(), ijkToWorld);
  });
  return done ? output : nullptr;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Resample(vtkMRMLInnerGSModelNode* model, double spacing,
                                                         vtkMRMLScalarVolumeNode* output) {
  const bool done = this->Work->guard([&] {
    if (!(spacing >= 0)) throw Error(ErrorCode::InvalidArgument, "The spacing must be above 0 mm, or 0.");
    vtkNew<vtkInnerGSResample> resample;
    resample->SetModel(mrml::modelOf(model));
    resample->SetOutputSpacing(spacing, spacing, spacing);
    resample->GeometryInImageOff();
    vtkNew<vtkMatrix4x4> toWorld, ijkToWorld;
    mrml::toWorld(model, toWorld);
    mrml::run(resample);
    vtkMatrix4x4::Multiply4x4(toWorld, resample->GetOutputIJKToRASMatrix(), ijkToWorld);
    output = this->Work->volumeFor(output, model, " resampled");
    mrml::setVolume(output, resample->GetOutput(), ijkToWorld);
  });
  return done ? output : nullptr;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ResampleLike(vtkMRMLInnerGSModelNode* model,
                                                             vtkMRMLVolumeNode* reference,
                                                             vtkMRMLScalarVolumeNode* output) {
  const bool done = this->Work->guard([&] {
    if (!reference) throw Error(ErrorCode::InvalidArgument, "There is no reference volume: choose one.");
    if (output == reference)
      throw Error(ErrorCode::InvalidArgument, "The output is the reference as well: choose another.");
    vtkNew<vtkInnerGSResample> resample;
    resample->SetModel(mrml::modelOf(model));
    mrml::gridOf(reference); // refuses what is no lattice
    vtkNew<vtkMatrix4x4> toModel, ijkToWorld, ijkToModel;
    mrml::fromWorld(model, toModel);
    mrml::ijkToWorld(reference, ijkToWorld);
    vtkMatrix4x4::Multiply4x4(toModel, ijkToWorld, ijkToModel);
    int size[3];
    reference->GetImageData()->GetDimensions(size);
    resample->SetReferenceGrid(ijkToModel, size[0], size[1], size[2]);
    resample->GeometryInImageOff();
    mrml::run(resample);
    output = this->Work->volumeFor(output, model, " resampled");
    mrml::setVolume(output, resample->GetOutput(), ijkToWorld, reference);
  });
  return done ? output : nullptr;
}

//------------------------------------------------------------------------------

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::FollowSlice(vtkMRMLInnerGSModelNode* model,
                                                            vtkMRMLSliceNode* slice,
                                                            vtkMRMLScalarVolumeNode* output) {
  const bool done = this->Work->guard([&] {
    mrml::modelOf(model);
    if (!slice) throw Error(ErrorCode::InvalidArgument, "There is no slice view to follow: choose one.");
    vtkNew<vtkMatrix4x4> toModel;
    mrml::fromWorld(model, toModel);
    output = this->Work->volumeFor(output, model, " slice");
    this->StopFollowing(output);
    auto follower = std::make_unique<mrml::SliceFollower>(
        model, slice, output, this->MaximumFollowPixels,
        [this](const std::string& sentence) { this->Work->fail(sentence); });
    follower->update();
    this->Work->followers.push_back(std::move(follower));
  });
  return done ? output : nullptr;
}

void vtkSlicerInnerGSLogic::StopFollowing(vtkMRMLScalarVolumeNode* output) {
  std::erase_if(this->Work->followers,
                [&](const auto& follower) { return !output || follower->output() == output; });
}

bool vtkSlicerInnerGSLogic::IsFollowing(vtkMRMLScalarVolumeNode* output) {
  for (const auto& follower : this->Work->followers)
    if (output && follower->output() == output) return true;
  return false;
}

vtkMRMLModelNode* vtkSlicerInnerGSLogic::CreateGaussianModel(vtkMRMLInnerGSModelNode* model, int maximum,
                                                             vtkMRMLModelNode* output) {
  const bool done = this->Work->guard([&] {
    vtkNew<vtkInnerGSToPolyData> filter;
    filter->SetModel(mrml::modelOf(model));
    filter->SetMaximumNumberOfGaussians(maximum);
    mrml::run(filter);
    vtkMRMLScene* scene = this->GetMRMLScene();
    if (!output) {
      if (!scene)
        throw Error(ErrorCode::InvalidArgument, "The logic has no scene to add a model to: set one.");
      const std::string name = std::string(model->GetName() ? model->GetName() : "Model") + " Gaussians";
      output = vtkMRMLModelNode::SafeDownCast(mrml::addNode(scene, "vtkMRMLModelNode", name));
      output->CreateDefaultDisplayNodes();
      mrml::placeBeside(output, model);
    }
    output->SetAndObserveTransformNodeID(model->GetTransformNodeID());
    vtkNew<vtkPolyData> own;
    own->ShallowCopy(filter->GetOutput());
    output->SetAndObservePolyData(own);
  });
  return done ? output : nullptr;
}

vtkMRMLInnerGSModelNode* vtkSlicerInnerGSLogic::LoadModel(const std::string& fileName) {
  vtkMRMLInnerGSModelNode* result = nullptr;
  this->Work->guard([&] {
    vtkMRMLScene* scene = this->GetMRMLScene();
    if (!scene) throw Error(ErrorCode::InvalidArgument, "The logic has no scene to load into: set one.");
    vtkNew<vtkMRMLInnerGSModelStorageNode> storage;
    vtkNew<vtkMRMLInnerGSModelNode> node;
    vtkNew<vtkCallbackCommand> quiet;
    const unsigned long tag = storage->AddObserver(vtkCommand::ErrorEvent, quiet);
    storage->SetFileName(fileName.c_str());
    const int read = storage->ReadData(node);
    storage->RemoveObserver(tag);
    if (!read)
      throw Error(ErrorCode::FileFormat,
                  storage->GetErrorMessage().empty()
                      ? "'" + fileName + "' could not be read: choose an .innergs or .ply file."
                      : storage->GetErrorMessage());
    const std::string file = storage->GetFileNameWithoutExtension(fileName.c_str());
    const std::string name = file.substr(file.find_last_of("/\\") + 1);
    node->SetName(scene->GenerateUniqueName(name.empty() ? "InnerGS model" : name).c_str());
    scene->AddNode(storage);
    scene->AddNode(node);
    node->SetAndObserveStorageNodeID(storage->GetID());
    result = node;
  });
  return result;
}

bool vtkSlicerInnerGSLogic::SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  return this->Work->guard([&] {
    mrml::modelOf(model);
    vtkNew<vtkMRMLInnerGSModelStorageNode> storage; // the node keeps its own place in the scene
    vtkNew<vtkCallbackCommand> quiet;
    storage->AddObserver(vtkCommand::ErrorEvent, quiet);
    storage->SetFileName(fileName.c_str());
    if (!storage->WriteData(model))
      throw Error(ErrorCode::Io,
                  storage->GetErrorMessage().empty()
                      ? "'" + fileName +
                            "' could not be written: choose a file name that ends with .innergs or .ply."
                      : storage->GetErrorMessage());
  });
}
