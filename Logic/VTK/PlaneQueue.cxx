#include "PlaneQueue.h"

#include "Core/Base/Failure.h"
#include "Core/Base/ThreadPriority.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"

#include "vtkCallbackCommand.h"

#include <algorithm>
#include <utility>

namespace innergs {

PlaneQueue::PlaneQueue(bool background) : background_(background) {
  query_->CentredOff();
  query_->GeometryInImageOff();
  vtkNew<vtkCallbackCommand> silent; // the answers carry the errors
  silent->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  query_->AddObserver(vtkCommand::ErrorEvent, silent);
}

PlaneQueue::~PlaneQueue() {
  {
    std::lock_guard lock(mutex_);
    quit_ = true;
    query_->Cancel();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void PlaneQueue::request(int key, PlaneRequest request, Answer answer, std::chrono::milliseconds rest) {
  if (!thread_.joinable()) thread_ = std::thread([this] { work(); });
  {
    std::lock_guard lock(mutex_);
    waiting_[key] = {std::move(request), std::move(answer), Clock::now() + rest};
  }
  changed_.notify_all();
}

void PlaneQueue::interrupt(int key) {
  std::lock_guard lock(mutex_);
  if (current_ == key) query_->Cancel();
}

void PlaneQueue::drop(int key) {
  std::lock_guard lock(mutex_);
  waiting_.erase(key);
}

QueriedPlane PlaneQueue::query(const PlaneRequest& request) {
  QueriedPlane plane;
  if (queried_ != request.model) {
    vtkNew<vtkInnerGSModel> model; // its own data object, sharing the Gaussians
    model->SetCoreModel(request.model);
    query_->SetModel(model);
    queried_ = request.model;
  }
  vtkNew<vtkImageData> deviation; // with information of its own, sharing the voxels
  if (request.deviation) deviation->ShallowCopy(request.deviation);
  query_->SetStandardDeviationData(request.deviation ? deviation.Get() : nullptr);
  query_->SetStandardDeviationIJKToRASMatrix(request.deviationIJKToRAS);
  query_->SetTransformToModel(request.toModel);
  query_->SetPlaneToRASMatrix(request.planeToRAS);
  query_->SetSpacing(request.spacing, request.spacing);
  query_->SetDimensions(request.columns, request.rows);
  plane.image = query_->Query();
  plane.error = query_->GetErrorMessage();
  plane.milliseconds = query_->GetQueryMilliseconds();
  if (!plane.image) return plane;
  plane.ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  plane.ijkToRAS->DeepCopy(query_->GetOutputIJKToRASMatrix());
  if (request.deviation) {
    plane.deviation = vtkSmartPointer<vtkImageData>::New();
    plane.deviation->ShallowCopy(query_->GetOutputStandardDeviation());
  }
  return plane;
}

void PlaneQueue::work() {
  if (background_) lowerThreadPriority();
  std::unique_lock lock(mutex_);
  while (!quit_) {
    const auto now = Clock::now();
    const auto next = std::find_if(waiting_.begin(), waiting_.end(),
                                   [&](const auto& entry) { return entry.second.due <= now; });
    if (next == waiting_.end()) {
      const auto soonest =
          std::min_element(waiting_.begin(), waiting_.end(),
                           [](const auto& a, const auto& b) { return a.second.due < b.second.due; });
      if (soonest == waiting_.end())
        changed_.wait(lock);
      else
        changed_.wait_until(lock, Clock::time_point(soonest->second.due));
      continue;
    }
    const int key = next->first;
    Waiting task = std::move(next->second);
    waiting_.erase(next);
    current_ = key;
    lock.unlock();
    QueriedPlane plane;
    if (const std::string error = sentenceOf([&] { plane = query(task.request); }); !error.empty()) {
      plane = {};
      plane.error = error;
    }
    if (background_) {
      query_->SetModel(nullptr);
      queried_.reset();
    }
    lock.lock();
    current_.reset();
    if (quit_) break;
    if (!plane.image && plane.error.empty()) { // interrupted
      waiting_.try_emplace(key, std::move(task));
      continue;
    }
    lock.unlock();
    task.answer(plane);
    task = {}; // its objects are released without the lock
    lock.lock();
  }
}

} // namespace innergs
