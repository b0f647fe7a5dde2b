#include "FinePlanes.h"

#include "Core/Base/Failure.h"
#include "SliceFollower.h"

#include <chrono>
#include <utility>

namespace innergs::mrml {

namespace {

constexpr std::chrono::milliseconds kRest{250}; // without movement

} // namespace

FinePlanes::FinePlanes(std::function<void()> wake) : wake_(std::move(wake)), queue_(true) {}

void FinePlanes::request(const std::shared_ptr<SliceFollower>& follower, int revision, PlaneRequest request) {
  const auto answer = [this, revision, key = std::weak_ptr(follower)](const QueriedPlane& plane) {
    if (!plane.image) return; // the coarse plane stays, and has reported the error
    {
      std::lock_guard lock(mutex_);
      done_.push_back({key, revision, plane});
    }
    wake_();
  };
  sentenceOf([&] { // if no thread can be started, the coarse planes stay
    queue_.request(follower->id(), std::move(request), answer, kRest);
    queue_.interrupt(follower->id());
  });
}

void FinePlanes::drop(const SliceFollower& follower) {
  queue_.drop(follower.id());
}

std::optional<FinePlanes::Plane> FinePlanes::fetch() {
  std::lock_guard lock(mutex_);
  if (done_.empty()) return std::nullopt;
  Plane plane = std::move(done_.front());
  done_.pop_front();
  return plane;
}

} // namespace innergs::mrml
