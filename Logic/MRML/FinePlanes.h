#pragma once
#include "PlaneQueue.h"

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>

namespace innergs::mrml {

class SliceFollower;

/// Queries planes in full resolution, once their views have been at rest. Call everything on the main thread.
class FinePlanes {
public:
  struct Plane {
    std::weak_ptr<SliceFollower> follower;
    int revision = 0; // the follower's, which drops older ones
    QueriedPlane queried;
  };
  /// wake: called on the queue's thread when there is a plane to fetch.
  explicit FinePlanes(std::function<void()> wake);

  /// Replaces and stops the follower's last request.
  void request(const std::shared_ptr<SliceFollower>& follower, int revision, PlaneRequest request);
  /// Forgets the follower's request.
  void drop(const SliceFollower& follower);
  std::optional<Plane> fetch();

private:
  std::function<void()> wake_;
  std::mutex mutex_;
  std::deque<Plane> done_;
  PlaneQueue queue_; // last: its thread uses the others
};

} // namespace innergs::mrml
