#include "JobQueue.h"

#include "Core/Base/Failure.h"
#include "Core/Base/ThreadPriority.h"
#include "DynamicWork.h"

#include <vtkMRMLSequenceNode.h>

#include <vtkCallbackCommand.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace innergs::mrml {
namespace {

/// Calls a function at an event of the filter, on the filter's thread.
class Observation {
public:
  Observation(vtkObject* object, unsigned long event, std::function<void(void*)> call)
      : object_(object), call_(std::move(call)) {
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void* data) {
      static_cast<Observation*>(self)->call_(data);
    });
    tag_ = object_->AddObserver(event, command_);
  }
  ~Observation() { object_->RemoveObserver(tag_); }
  Observation(const Observation&) = delete;
  Observation& operator=(const Observation&) = delete;

private:
  vtkObject* object_;
  std::function<void(void*)> call_;
  vtkNew<vtkCallbackCommand> command_;
  unsigned long tag_;
};

} // namespace

JobQueue::JobQueue(std::function<void()> wake) : wake_(std::move(wake)) {}

JobQueue::~JobQueue() {
  {
    std::lock_guard lock(mutex_);
    quit_ = true;
    for (const auto& task : open_) {
      task->stop.request_stop();
      if (task->filter) task->filter->Cancel();
    }
  }
  toDo_.notify_all();
  if (worker_.joinable()) worker_.join();
}

void JobQueue::submit(std::shared_ptr<Task> task) {
  try {
    if (!worker_.joinable()) worker_ = std::thread([this] { work(); });
  } catch (...) { // no thread could be started
    task->failure = failureOf();
  }
  const bool fails = !task->failure.sentence.empty();
  {
    std::lock_guard lock(mutex_);
    open_.push_back(task);
    if (!fails) waiting_.push_back(task);
  }
  if (fails)
    post(std::move(task), [](JobUpdate& update) { update.done = true; });
  else
    toDo_.notify_one();
}

void JobQueue::cancel(const std::shared_ptr<Task>& task) {
  bool waiting = false;
  {
    std::lock_guard lock(mutex_);
    const auto found = std::find(waiting_.begin(), waiting_.end(), task);
    waiting = found != waiting_.end();
    if (waiting) waiting_.erase(found); // it need not wait for those before
  }
  task->stop.request_stop();
  if (!waiting) {
    if (task->filter) task->filter->Cancel();
    return;
  }
  task->cancelled = true;
  post(task, [](JobUpdate& update) { update.done = true; });
}

std::vector<std::shared_ptr<Task>> JobQueue::tasks() const {
  std::lock_guard lock(mutex_);
  return {open_.begin(), open_.end()};
}

std::optional<JobUpdate> JobQueue::fetch() {
  std::lock_guard lock(mutex_);
  awake_ = false;
  auto found = updates_.end();
  for (const auto& task : open_) {
    const auto at = updates_.find(task.get());
    if (at == updates_.end()) continue;
    if (found == updates_.end() || at->second.done) found = at;
    if (at->second.done) break; // frequent updates of a running task must not keep others from ending
  }
  if (found == updates_.end()) return std::nullopt;
  JobUpdate& rest = found->second;
  JobUpdate next;
  next.task = rest.task;
  if (rest.started) {
    next.started = std::exchange(rest.started, false);
  } else if (rest.progress && !(rest.previewNext && rest.hasPreview())) {
    next.progress.swap(rest.progress);
    rest.previewNext = true;
  } else if (rest.hasPreview()) {
    next.preview = std::exchange(rest.preview, nullptr);
    next.previewToRAS = std::exchange(rest.previewToRAS, nullptr);
    next.dynamic = std::exchange(rest.dynamic, nullptr);
    rest.previewNext = false;
  } else {
    next.done = rest.done;
    std::erase(open_, next.task);
    rest.done = false;
  }
  if (!rest.progress && !rest.hasPreview() && !rest.done) updates_.erase(found);
  return next;
}

bool JobQueue::wait(double seconds) {
  std::unique_lock lock(mutex_);
  return arrived_.wait_for(lock, std::chrono::duration<double>(seconds), [&] { return !updates_.empty(); });
}

void JobQueue::post(std::shared_ptr<Task> task, const std::function<void(JobUpdate&)>& write) {
  bool wake = false;
  {
    std::lock_guard lock(mutex_);
    JobUpdate& update = updates_[task.get()];
    update.task = std::move(task);
    write(update);
    wake = !awake_;
    awake_ = true;
  }
  arrived_.notify_all();
  if (wake && wake_) wake_();
}

void JobQueue::work() {
  lowerThreadPriority(); // the application's views have priority
  for (;;) {
    std::shared_ptr<Task> task;
    {
      std::unique_lock lock(mutex_);
      toDo_.wait(lock, [&] { return quit_ || !waiting_.empty(); });
      if (quit_) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
    }
    post(task, [](JobUpdate& update) { update.started = true; });
    try {
      execute(task);
    } catch (...) {
      task->failure = failureOf();
    }
    post(std::move(task), [](JobUpdate& update) { update.done = true; });
  }
}

void JobQueue::execute(const std::shared_ptr<Task>& task) {
  const ProgressCallback told = [&](const innergs::Progress& progress) {
    task->judging = task->judging || resultIsComplete(progress.phase);
    post(task, [&](JobUpdate& update) {
      const std::string note = update.progress ? update.progress->note : std::string();
      update.progress = progress;
      if (progress.note.empty()) update.progress->note = note; // told once
    });
  };
  if (task->work) {
    task->work(task->stop.get_token(), unstoppable_, told);
    return;
  }
  if (task->dynamic) {
    task->cancelled = !task->dynamic->run(task->stop.get_token(), told, [&](const auto& field) {
      post(task, [&](JobUpdate& update) { update.dynamic = field; });
    });
    if (task->keep || (task->cancelled && task->dynamic->keepsWhenCancelled())) keepFit(*task);
    return;
  }
  JobFilter* filter = task->filter;
  filter->unstoppable = &unstoppable_;
  filter->told = told;
  const Observation preview(filter, vtkInnerGSReconstruct::PreviewEvent, [&](void* data) {
    const vtkSmartPointer<vtkImageData> image = static_cast<vtkImageData*>(data);
    vtkNew<vtkMatrix4x4> matrix;
    matrix->DeepCopy(filter->GetPreviewIJKToRASMatrix());
    post(task, [&](JobUpdate& update) {
      update.preview = image;
      update.previewToRAS = matrix;
    });
  });
  filter->Update();
  filter->told = nullptr;
  task->cancelled = filter->GetAborted();
  if (task->keep) keepFit(*task);
  task->report = std::move(filter->quality);
  filter->RethrowError();
}

} // namespace innergs::mrml
