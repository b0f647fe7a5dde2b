#pragma once
#include "DetachedTasks.h"
#include "JobSetup.h"

#include "Core/Motion/DynamicField.h"

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>

namespace innergs::mrml {

/// Updates of a task from the worker; newer ones replace those not fetched in time. Fetched one by one, so
/// that what an observer of the first does (cancel, wait, clear the scene) still affects the others.
struct JobUpdate {
  std::shared_ptr<Task> task;
  bool started = false, done = false;
  bool previewNext = false; // frequent progress must not hold the preview back
  std::optional<Progress> progress;
  vtkSmartPointer<vtkImageData> preview;
  vtkSmartPointer<vtkMatrix4x4> previewToRAS;
  std::shared_ptr<const DynamicField> dynamic; // preview of a dynamic scan

  bool hasPreview() const { return preview || dynamic; }
};

/// Runs tasks one after another on a thread of its own. Call everything on the main thread.
class JobQueue {
public:
  /// wake: called on the worker for the first update after a fetch.
  explicit JobQueue(std::function<void()> wake);
  /// Stops everything and waits for the worker to end.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// Where the worker cannot be started, the task ends with that failure.
  void submit(std::shared_ptr<Task> task);
  /// Asks a task to end; its last update follows within 200 ms, or once the state to be kept is written.
  void cancel(const std::shared_ptr<Task>& task);

  /// The tasks whose last update has not been fetched, in order.
  std::vector<std::shared_ptr<Task>> tasks() const;
  /// The oldest task's next single update, if there is one. After `done` no others follow.
  std::optional<JobUpdate> fetch();
  /// Waits for an update; false when none comes in time.
  bool wait(double seconds);

private:
  void work();
  void execute(const std::shared_ptr<Task>& task);
  /// Gives the task away: after its last update it belongs to the main thread alone, weak pointers included.
  void post(std::shared_ptr<Task> task, const std::function<void(JobUpdate&)>& write);

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable toDo_, arrived_;
  std::deque<std::shared_ptr<Task>> waiting_, open_; // to be worked on; with updates to come or to be fetched
  std::map<Task*, JobUpdate> updates_;
  bool awake_ = false; // wake_ was called and nothing fetched since
  bool quit_ = false;  // the worker is to end
  DetachedTasks unstoppable_;
  std::thread worker_;
};

} // namespace innergs::mrml
