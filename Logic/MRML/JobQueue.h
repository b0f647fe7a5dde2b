#pragma once
#include "DetachedTasks.h"
#include "JobSetup.h"

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

/// What the worker tells about a task; newer tidings replace those that were not fetched in time. Fetched one
/// by one: what an observer of the first does (cancel, wait, clear the scene) still meets the others here.
struct JobUpdate {
  std::shared_ptr<Task> task;
  bool started = false, done = false;
  bool previewNext = false; // progress that comes fast must not hold the preview back
  std::optional<Progress> progress;
  vtkSmartPointer<vtkImageData> preview;
  vtkSmartPointer<vtkMatrix4x4> previewToRAS;
};

/// Does tasks one after the other on a thread of its own. Everything but that thread's work is called on the
/// main thread.
class JobQueue {
public:
  /// wake: called on the worker when there is update and the last call's update was fetched.
  explicit JobQueue(std::function<void()> wake);
  /// Stops everything and waits for the worker's end.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// A task whose worker cannot be started ends with that as its failure.
  void submit(std::shared_ptr<Task> task);
  /// Asks a task to end; its last update follows within 200 ms.
  void cancel(const std::shared_ptr<Task>& task);

  /// Tasks whose last update was not fetched yet, in order.
  std::vector<std::shared_ptr<Task>> tasks() const;
  /// The oldest task's next single tiding, if there is any. With `done` the task is closed: no others follow.
  std::optional<JobUpdate> fetch();
  /// Waits for update; false when there is none in time.
  bool wait(double seconds);

private:
  void work();
  void execute(const std::shared_ptr<Task>& task);
  /// Gives the task away: with its last update it belongs to the main thread alone, weak pointers included.
  void post(std::shared_ptr<Task> task, const std::function<void(JobUpdate&)>& write);

  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::condition_variable toDo_, arrived_;
  std::deque<std::shared_ptr<Task>> waiting_, open_; // to be worked on; with update to come or to be fetched
  std::map<Task*, JobUpdate> updates_;
  bool awake_ = false; // wake_ was called and nothing fetched since
  bool quit_ = false;  // the worker is to end
  DetachedTasks unstoppable_;
  std::thread worker_;
};

} // namespace innergs::mrml
