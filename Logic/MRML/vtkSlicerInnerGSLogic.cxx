#include "vtkSlicerInnerGSLogic.h"

#include "Core/Error.h"
#include "JobDelivery.h"
#include "ModelNodes.h"
#include "Queries.h"
#include "SliceFollower.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSliceNode.h>
#include <vtkSlicerApplicationLogic.h>

#include <vtkCallbackCommand.h>
#include <vtkFloatArray.h>
#include <vtkObjectFactory.h>
#include <vtkPoints.h>

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
  mrml::JobDelivery delivery;

  // The application's event loop modifies the bell on the main thread when the worker asks for it.
  vtkNew<vtkObject> bell;
  vtkNew<vtkCallbackCommand> onBell;
  std::atomic<vtkSlicerApplicationLogic*> application = nullptr;
  std::atomic<bool> delivered = false; // an application took the worker's last call

  mrml::JobQueue queue; // last: its worker ends before the rest goes

  explicit Internals(vtkSlicerInnerGSLogic* owner)
      : logic(owner), delivery(owner, [this](const std::string& sentence) { this->fail(sentence); }),
        queue([this] { this->ring(); }) {
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

//------------------------------------------------------------------------------

vtkSlicerInnerGSLogic::vtkSlicerInnerGSLogic() : Work(std::make_unique<Internals>(this)) {}

vtkSlicerInnerGSLogic::~vtkSlicerInnerGSLogic() {
  for (const auto& task : this->Work->queue.tasks())
    mrml::JobDelivery::abandon(task->job);
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
    this->Work->delivery.deliver(*mail);
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
  const bool done = this->Work->guard([&] { mrml::evaluate(model, points, values); });
  if (!done && values) values->Initialize();
  return done;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::QueryPlane(vtkMRMLInnerGSModelNode* model,
                                                           vtkMatrix4x4* planeToRAS, int columns, int rows,
                                                           double spacing, vtkMRMLScalarVolumeNode* output) {
  const bool done = this->Work->guard([&] {
    output = mrml::queryPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing, output);
  });
  return done ? output : nullptr;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Resample(vtkMRMLInnerGSModelNode* model, double spacing,
                                                         vtkMRMLScalarVolumeNode* output) {
  const bool done =
      this->Work->guard([&] { output = mrml::resample(this->GetMRMLScene(), model, spacing, output); });
  return done ? output : nullptr;
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ResampleLike(vtkMRMLInnerGSModelNode* model,
                                                             vtkMRMLVolumeNode* reference,
                                                             vtkMRMLScalarVolumeNode* output) {
  const bool done =
      this->Work->guard([&] { output = mrml::resampleLike(this->GetMRMLScene(), model, reference, output); });
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
    output = mrml::volumeFor(this->GetMRMLScene(), output, model, " slice");
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
  const bool done = this->Work->guard(
      [&] { output = mrml::makeGaussianModel(this->GetMRMLScene(), model, maximum, output); });
  return done ? output : nullptr;
}

vtkMRMLInnerGSModelNode* vtkSlicerInnerGSLogic::LoadModel(const std::string& fileName) {
  vtkMRMLInnerGSModelNode* result = nullptr;
  this->Work->guard([&] { result = mrml::loadModel(this->GetMRMLScene(), fileName); });
  return result;
}

bool vtkSlicerInnerGSLogic::SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  return this->Work->guard([&] { mrml::saveModel(model, fileName); });
}
