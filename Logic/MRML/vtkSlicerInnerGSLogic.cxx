#include "vtkSlicerInnerGSLogic.h"

#include "Core/Error.h"
#include "JobDelivery.h"
#include "ModelNodes.h"
#include "Outputs.h"
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

#include <chrono>
#include <limits>
#include <mutex>

vtkStandardNewMacro(vtkSlicerInnerGSLogic);

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

namespace {

/// What a caller may hold as a plain pointer: null when an observer removed the node from the scene and
/// nobody else keeps it.
template <class Node>
Node* kept(const vtkSmartPointer<Node>& made, Node* given) {
  return made && ((made == given && made->GetReferenceCount() > 1) || made->GetScene()) ? made.Get()
                                                                                        : nullptr;
}

} // namespace

struct vtkSlicerInnerGSLogic::Internals {
  vtkSlicerInnerGSLogic* logic;
  std::thread::id mainThread = std::this_thread::get_id();
  std::string lastError;
  vtkSmartPointer<vtkSlicerInnerGSJob> lastJob;
  std::vector<std::shared_ptr<mrml::SliceFollower>> followers;
  mrml::JobDelivery delivery;

  // The application's event loop modifies the bell on the main thread when the worker asks for it.
  vtkNew<vtkObject> bell;
  vtkNew<vtkCallbackCommand> onBell;
  std::mutex applicationMutex; // the worker must not ring at one that is going
  vtkSlicerApplicationLogic* application = nullptr;
  vtkNew<vtkCallbackCommand> onApplicationGone, onOwnEnd;

  mrml::JobQueue queue; // last: its worker ends before the rest goes

  explicit Internals(vtkSlicerInnerGSLogic* owner)
      : logic(owner), delivery(owner, [this](const std::string& sentence) { this->fail(sentence); }),
        queue([this] { this->ring(); }) {
    onBell->SetClientData(owner);
    onBell->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
      static_cast<vtkSlicerInnerGSLogic*>(self)->ProcessPendingEvents();
    });
    bell->AddObserver(vtkCommand::ModifiedEvent, onBell);
    onApplicationGone->SetClientData(owner);
    onApplicationGone->SetCallback([](vtkObject*, unsigned long, void* self, void*) {
      static_cast<vtkSlicerInnerGSLogic*>(self)->SetMRMLApplicationLogic(nullptr);
    });
    onOwnEnd->SetClientData(this);
    onOwnEnd->SetCallback(
        [](vtkObject*, unsigned long, void* self, void*) { static_cast<Internals*>(self)->abandonJobs(); });
    owner->AddObserver(vtkCommand::DeleteEvent, onOwnEnd);
  }
  ~Internals() {
    bell->RemoveObserver(onBell);
    if (application) application->RemoveObserver(onApplicationGone);
  }

  void setApplication(vtkSlicerApplicationLogic* next) {
    if (next == application) return;
    if (application) application->RemoveObserver(onApplicationGone);
    {
      std::lock_guard lock(applicationMutex);
      application = next;
    }
    if (!next) return;
    next->AddObserver(vtkCommand::DeleteEvent, onApplicationGone);
    if (!queue.tasks().empty()) next->RequestModified(bell); // the one before may not have passed on the call
  }
  void abandonJobs() {
    for (const auto& task : queue.tasks()) {
      task->discard = true;
      queue.cancel(task);
      delivery.abandon(task->job, false); // an event of an object that is going must not reach Python
    }
  }

  void ring() { // on the worker
    std::lock_guard lock(applicationMutex);
    if (application) application->RequestModified(bell);
  }

  /// Runs the task; what it throws becomes an ErrorEvent and the last error. False then.
  bool guard(const std::function<void()>& task);
  void fail(const std::string& sentence);
  std::shared_ptr<mrml::Task> taskOf(vtkSlicerInnerGSJob* job) const;
};

bool vtkSlicerInnerGSLogic::Internals::guard(const std::function<void()>& task) {
  const vtkSmartPointer<vtkObject> alive = logic; // an observer of what the task makes may let go of it
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
  const vtkSmartPointer<vtkObject> alive = logic; // an observer may let go of it
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

vtkSlicerInnerGSLogic::~vtkSlicerInnerGSLogic() = default;

void vtkSlicerInnerGSLogic::SetMRMLApplicationLogic(vtkMRMLApplicationLogic* application) {
  this->Superclass::SetMRMLApplicationLogic(application);
  this->Work->setApplication(vtkSlicerApplicationLogic::SafeDownCast(application));
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
  this->Work->delivery.discard();
  this->Cancel();
}

void vtkSlicerInnerGSLogic::OnMRMLSceneNodeRemoved(vtkMRMLNode* node) {
  std::erase_if(this->Work->followers, [&](const auto& follower) { return follower->concerns(node); });
  for (const auto& task : this->Work->queue.tasks())
    if (task->parameters.Get() == node) {
      task->discard = true;
      this->Work->queue.cancel(task);
    }
  mrml::leaveHierarchy(node, this->GetMRMLScene());
}

//------------------------------------------------------------------------------

vtkSlicerInnerGSJob* vtkSlicerInnerGSLogic::StartReconstruction(vtkMRMLInnerGSParameterNode* parameters,
                                                                bool copyVoxels) {
  Internals& work = *this->Work;
  const bool started = work.guard([&] {
    std::shared_ptr<mrml::Task> task =
        mrml::prepare(parameters, this->GetMRMLScene(), copyVoxels || this->GetNumberOfJobs() > 0);
    task->job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    task->job->ParameterNode = parameters;
    work.lastJob = task->job;
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
  int count = 0;
  // One round: a worker that tells faster than observers listen must not keep the main thread here.
  const int limit = 4 * this->GetNumberOfJobs(); // started, progress, preview, done
  for (; count < limit; ++count) {
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

double vtkSlicerInnerGSLogic::EstimateSeconds(vtkMRMLInnerGSParameterNode* parameters) {
  try {
    return mrml::outlineOf(parameters, this->GetMRMLScene()).seconds();
  } catch (const std::exception&) {
    return 0;
  }
}

std::function<vtkSlicerInnerGSLogic::SlowEstimate()>
vtkSlicerInnerGSLogic::EstimateLater(vtkMRMLInnerGSParameterNode* parameters, std::string* key) {
  try {
    const auto outline = std::make_shared<mrml::Outline>(mrml::outlineOf(parameters, this->GetMRMLScene()));
    if (key) *key = outline->key();
    return [outline] {
      SlowEstimate estimate;
      estimate.device = outline->device();
      try {
        estimate.seconds = outline->seconds();
      } catch (const std::exception&) { // unknown
      }
      return estimate;
    };
  } catch (const std::exception&) {
    return {};
  }
}

std::string vtkSlicerInnerGSLogic::DescribeDevice(vtkMRMLInnerGSParameterNode* parameters) {
  return parameters ? mrml::describeDevice(parameters) : "";
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
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] {
    made = mrml::queryPlane(this->GetMRMLScene(), model, planeToRAS, columns, rows, spacing, output);
  });
  return kept(made, output);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::Resample(vtkMRMLInnerGSModelNode* model, double spacing,
                                                         vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] { made = mrml::resample(this->GetMRMLScene(), model, spacing, output); });
  return kept(made, output);
}

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::ResampleLike(vtkMRMLInnerGSModelNode* model,
                                                             vtkMRMLVolumeNode* reference,
                                                             vtkMRMLScalarVolumeNode* output) {
  vtkSmartPointer<vtkMRMLScalarVolumeNode> made;
  this->Work->guard([&] { made = mrml::resampleLike(this->GetMRMLScene(), model, reference, output); });
  return kept(made, output);
}

//------------------------------------------------------------------------------

vtkMRMLScalarVolumeNode* vtkSlicerInnerGSLogic::FollowSlice(vtkMRMLInnerGSModelNode* model,
                                                            vtkMRMLSliceNode* slice,
                                                            vtkMRMLScalarVolumeNode* output) {
  const vtkSmartPointer<vtkSlicerInnerGSLogic> alive =
      this; // an observer may let go of it, or remove the nodes
  const vtkSmartPointer<vtkMRMLInnerGSModelNode> keptModel = model;
  const vtkSmartPointer<vtkMRMLSliceNode> keptSlice = slice;
  vtkSmartPointer<vtkMRMLScalarVolumeNode> shown;
  const bool done = this->Work->guard([&] {
    mrml::modelOf(model);
    if (!slice) throw Error(ErrorCode::InvalidArgument, "There is no slice view to follow: choose one.");
    const auto follower = std::make_shared<mrml::SliceFollower>(
        model, slice, this->MaximumFollowPixels,
        [this](const std::string& sentence) { this->Work->fail(sentence); });
    follower->query(); // throws before anything is changed
    shown = mrml::volumeFor(this->GetMRMLScene(), output, model, " slice");
    if (!kept(shown, output) || (this->GetMRMLScene() && !model->GetScene())) return;
    this->StopFollowing(shown);
    mrml::setProvenance(shown, model);
    follower->setOutput(shown);
    this->Work->followers.push_back(follower);
    follower->show();
  });
  return done && this->IsFollowing(shown) ? shown.Get() : nullptr;
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
  vtkSmartPointer<vtkMRMLModelNode> made;
  this->Work->guard([&] { made = mrml::makeGaussianModel(this->GetMRMLScene(), model, maximum, output); });
  return kept(made, output);
}

vtkMRMLInnerGSModelNode* vtkSlicerInnerGSLogic::LoadModel(const std::string& fileName) {
  vtkMRMLInnerGSModelNode* result = nullptr;
  this->Work->guard([&] { result = mrml::loadModel(this->GetMRMLScene(), fileName); });
  return result;
}

bool vtkSlicerInnerGSLogic::SaveModel(vtkMRMLInnerGSModelNode* model, const std::string& fileName) {
  return this->Work->guard([&] { mrml::saveModel(model, fileName); });
}
