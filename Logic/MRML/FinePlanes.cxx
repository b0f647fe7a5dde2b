#include "FinePlanes.h"

#include "Core/Base/Failure.h"
#include "Core/Base/ThreadPriority.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"

#include <vtkCallbackCommand.h>

#include <algorithm>
#include <utility>

namespace innergs::mrml {

namespace {

constexpr std::chrono::milliseconds kRest{250}; // without movement

} // namespace

FinePlanes::FinePlanes(std::function<void()> wake) : wake_(std::move(wake)) {
  query_->CentredOff();
  query_->GeometryInImageOff();
  vtkNew<vtkCallbackCommand> quiet; // the coarse plane stays, and has reported the error
  query_->AddObserver(vtkCommand::ErrorEvent, quiet);
}

FinePlanes::~FinePlanes() {
  {
    std::lock_guard lock(mutex_);
    quit_ = true;
    query_->Cancel();
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void FinePlanes::request(const std::shared_ptr<SliceFollower>& follower, PlaneRequest request) {
  {
    std::lock_guard lock(mutex_);
    waiting_[follower] = {std::move(request), Clock::now() + kRest};
    if (current_.lock() == follower) query_->Cancel();
  }
  changed_.notify_all();
  if (!thread_.joinable())
    sentenceOf([&] { thread_ = std::thread([this] { work(); }); }); // on failure the coarse planes stay
}

std::optional<FinePlanes::Plane> FinePlanes::fetch() {
  std::lock_guard lock(mutex_);
  if (done_.empty()) return std::nullopt;
  Plane plane = std::move(done_.front());
  done_.pop_front();
  return plane;
}

FinePlanes::Plane FinePlanes::query(const Key& follower, const PlaneRequest& request) {
  Plane plane{follower, request.revision, nullptr, vtkSmartPointer<vtkMatrix4x4>::New()};
  vtkNew<vtkInnerGSModel> model; // its own, sharing the Gaussians
  model->SetCoreModel(request.model);
  query_->SetModel(model);
  query_->SetTransformToModel(request.toModel);
  query_->SetPlaneToRASMatrix(request.planeToRAS);
  query_->SetDimensions(request.columns, request.rows);
  query_->SetSpacing(request.spacing, request.spacing);
  plane.image = query_->Query();
  if (plane.image) plane.toRAS->DeepCopy(query_->GetOutputIJKToRASMatrix());
  query_->SetModel(nullptr);
  return plane;
}

void FinePlanes::work() {
  lowerThreadPriority();
  std::unique_lock lock(mutex_);
  while (!quit_) {
    const auto first = std::min_element(waiting_.begin(), waiting_.end(), [](const auto& a, const auto& b) {
      return a.second.due < b.second.due;
    });
    if (first == waiting_.end()) {
      changed_.wait(lock);
      continue;
    }
    if (const auto due = first->second.due; Clock::now() < due) {
      changed_.wait_until(lock, due);
      continue;
    }
    const Key follower = first->first;
    const PlaneRequest request = std::move(first->second.request);
    waiting_.erase(first);
    if (follower.expired()) continue;
    current_ = follower;
    lock.unlock();
    Plane plane;
    sentenceOf([&] { plane = query(follower, request); }); // on failure the coarse one stays
    lock.lock();
    current_.reset();
    if (quit_) continue;
    if (query_->GetAborted())
      waiting_.try_emplace(follower, Waiting{request, Clock::now()}); // it was stopped for another one
    if (!plane.image) continue;
    done_.push_back(std::move(plane));
    lock.unlock();
    wake_();
    lock.lock();
  }
}

} // namespace innergs::mrml
