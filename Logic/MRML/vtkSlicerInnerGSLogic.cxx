#include "vtkSlicerInnerGSLogic.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "IO/FilePath.h"
#include "LogicInternals.h"
#include "Outputs.h"
#include "SceneChoices.h"
#include "SliceThickness.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSModelStorageNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"

#include <vtkMRMLScene.h>
#include <vtkMRMLSequenceBrowserNode.h>
#include <vtkMRMLSequenceNode.h>

#include <vtkIntArray.h>
#include <vtkObjectFactory.h>

#include <algorithm>
#include <chrono>
#include <filesystem>

vtkStandardNewMacro(vtkSlicerInnerGSLogic);

using innergs::Error;
using innergs::ErrorCode;
namespace mrml = innergs::mrml;

bool vtkSlicerInnerGSLogic::Internals::guard(const std::function<void()>& task) {
  const vtkSmartPointer<vtkObject> alive = logic; // an observer of what the task makes may let go of it
  lastError = {};
  try {
    if (std::this_thread::get_id() != mainThread)
      throw Error(
          ErrorCode::InvalidArgument,
          "The InnerGS logic was called from a thread other than the one that made it: call it from the "
          "main thread.");
    task();
    return true;
  } catch (...) {
    fail(innergs::failureOf());
  }
  return false;
}

void vtkSlicerInnerGSLogic::Internals::fail(const innergs::Failure& failure) {
  const vtkSmartPointer<vtkObject> alive = logic; // an observer may let go of it
  lastError = failure;
  vtkErrorWithObjectMacro(logic, << failure.sentence);
}

void vtkSlicerInnerGSLogic::Internals::showFine(const std::shared_ptr<mrml::SliceFollower>& follower,
                                                const mrml::FinePlanes::Plane& plane) {
  const bool followed = std::find(followers.begin(), followers.end(), follower) != followers.end();
  if (!followed) return;
  try {
    follower->show(plane);
  } catch (...) {
    fail(innergs::failureOf());
  }
}

innergs::JobOutline vtkSlicerInnerGSLogic::Internals::outlineOf(vtkMRMLInnerGSParameterNode* parameters) {
  return mrml::outlineOf(parameters, logic->GetMRMLScene(), thicknessOf(), outlineMasks);
}

mrml::ThicknessOf vtkSlicerInnerGSLogic::Internals::thicknessOf() const {
  return [this](vtkMRMLVolumeNode* volume) { return mrml::dicomSliceThickness(volume, dicom); };
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
  std::erase_if(this->Work->followers, [&](const auto& follower) { return follower->concerns(node); });
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
  Internals& work = *this->Work;
  const bool started = work.guard([&] {
    std::shared_ptr<mrml::Task> task = mrml::prepare(parameters, this->GetMRMLScene(), work.thicknessOf(),
                                                     copyVoxels || this->GetNumberOfJobs() > 0);
    task->job = vtkSmartPointer<vtkSlicerInnerGSJob>::New();
    task->job->ParameterNode = parameters;
    task->recoveryFolder = innergs::pathOf(this->GetRecoveryFolder());
    const vtkSmartPointer<vtkSlicerInnerGSJob> job = task->job;
    work.queue.submit(std::move(task));
    work.lastJob = job;
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
  return mrml::dicomSliceThickness(volume, this->Work->dicom);
}

void vtkSlicerInnerGSLogic::SetDicomLookup(DicomLookup lookup) {
  this->Work->dicom = std::move(lookup);
}
