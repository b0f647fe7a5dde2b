#pragma once
#include "JobDelivery.h"
#include "OutlineMask.h"
#include "SegmentQueries.h"
#include "SliceFollower.h"
#include "vtkSlicerInnerGSJob.h"
#include "vtkSlicerInnerGSLogic.h"

#include <vtkSlicerApplicationLogic.h>

#include <vtkCallbackCommand.h>

#include <mutex>

namespace innergs::mrml {

/// A plain pointer that is safe to hold: null if an observer removed the node from the scene and nothing else
/// holds it.
template <class Node>
Node* kept(const vtkSmartPointer<Node>& made, Node* given) {
  return made && ((made == given && made->GetReferenceCount() > 1) || made->GetScene()) ? made.Get()
                                                                                        : nullptr;
}

} // namespace innergs::mrml

/// The state of the logic: its jobs, the followed slice views, and the way from the worker to the main
/// thread.
struct vtkSlicerInnerGSLogic::Internals {
  vtkSlicerInnerGSLogic* logic;
  std::thread::id mainThread = std::this_thread::get_id();
  innergs::Failure lastError; // no sentence: none
  vtkSmartPointer<vtkSlicerInnerGSJob> lastJob;
  std::vector<std::shared_ptr<innergs::mrml::SliceFollower>> followers;
  innergs::mrml::JobDelivery delivery;
  DicomLookup dicom;
  std::vector<innergs::mrml::OutlineMask> outlineMasks;
  std::string recoveryFolder; // "": the usual one
  innergs::mrml::SegmentQueries segments;

  // The application's event loop modifies the bell on the main thread when the worker requests it.
  vtkNew<vtkObject> bell;
  vtkNew<vtkCallbackCommand> onBell;
  std::mutex applicationMutex; // the worker must not ring one that is being deleted
  vtkSlicerApplicationLogic* application = nullptr;
  vtkNew<vtkCallbackCommand> onApplicationGone, onOwnEnd;

  innergs::mrml::FinePlanes fine; // of the views that are followed
  innergs::mrml::JobQueue queue;  // last: its worker ends before the rest is destroyed

  explicit Internals(vtkSlicerInnerGSLogic* owner)
      : logic(owner), delivery(owner, [this](const innergs::Failure& failure) { this->fail(failure); }),
        fine([this] { this->ring(); }), queue([this] { this->ring(); }) {
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
    if (!queue.tasks().empty())
      next->RequestModified(bell); // the last one may not have delivered the request
  }
  void abandonJobs() {
    for (const auto& task : queue.tasks()) {
      task->discard = task->keep = true;
      queue.cancel(task);
      delivery.abandon(task->job, false); // an event of an object being deleted must not reach Python
    }
  }

  void ring() { // on the worker
    std::lock_guard lock(applicationMutex);
    if (application) application->RequestModified(bell);
  }

  /// Runs the task; what it throws becomes an ErrorEvent and the last error, and it returns false.
  bool guard(const std::function<void()>& task);
  /// Starts the job of a task; null after an error.
  vtkSlicerInnerGSJob* start(const std::function<std::shared_ptr<innergs::mrml::Task>()>& prepare);
  /// Waits for a started job; false if it is null or does not finish.
  bool finishes(const vtkSmartPointer<vtkSlicerInnerGSJob>& job);
  /// A query's volume, made in `output` (which then follows no slice view) or a new node; null after an
  /// error.
  vtkMRMLScalarVolumeNode* answer(vtkMRMLScalarVolumeNode* output,
                                  const std::function<vtkSmartPointer<vtkMRMLScalarVolumeNode>()>& make);
  void fail(const innergs::Failure& failure);
  innergs::JobOutline outlineOf(vtkMRMLInnerGSParameterNode* parameters); // throws Error
  innergs::mrml::ThicknessOf thicknessOf() const;
  int passesOf(vtkMRMLVolumeNode* volume) const; // see GetNumberOfInterleavedPasses()
  void stopFollowing(const std::function<bool(const innergs::mrml::SliceFollower&)>& which);
  void showFine(const std::shared_ptr<innergs::mrml::SliceFollower>& follower,
                const innergs::mrml::FinePlanes::Plane& plane);
  std::shared_ptr<innergs::mrml::Task> taskOf(vtkSlicerInnerGSJob* job) const;
};
