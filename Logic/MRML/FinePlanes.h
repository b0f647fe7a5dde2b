#pragma once
#include <vtkAbstractTransform.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <chrono>
#include <condition_variable>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>

class vtkInnerGSPlaneQuery;

namespace innergs {
struct Model;
}

namespace innergs::mrml {

class SliceFollower;

/// A plane of a model, independent of all nodes.
struct PlaneRequest {
  std::shared_ptr<const Model> model;
  vtkSmartPointer<vtkAbstractTransform> toModel; // immutable, so another thread may use it; null: none
  vtkSmartPointer<vtkMatrix4x4> planeToRAS;
  int columns = 1, rows = 1;
  double spacing = 1; // of the pixels, in the plane's own units
  int revision = 0;   // the follower's, which drops older ones
};

/// Queries planes in full resolution on a thread, once their views have been at rest. Call everything on the
/// main thread.
class FinePlanes {
public:
  struct Plane {
    std::weak_ptr<SliceFollower> follower;
    int revision = 0;
    vtkSmartPointer<vtkImageData> image;
    vtkSmartPointer<vtkMatrix4x4> toRAS; // of the image
  };
  /// wake: called on the thread when there is a plane to fetch.
  explicit FinePlanes(std::function<void()> wake);
  ~FinePlanes();
  FinePlanes(const FinePlanes&) = delete;
  FinePlanes& operator=(const FinePlanes&) = delete;

  /// Replaces and stops the follower's last request.
  void request(const std::shared_ptr<SliceFollower>& follower, PlaneRequest request);
  std::optional<Plane> fetch();

private:
  using Clock = std::chrono::steady_clock;
  using Key = std::weak_ptr<SliceFollower>;
  struct Waiting {
    PlaneRequest request;
    Clock::time_point due;
  };
  void work();
  Plane query(const Key& follower, const PlaneRequest& request);

  std::function<void()> wake_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<Key, Waiting, std::owner_less<Key>> waiting_;
  std::deque<Plane> done_;
  Key current_; // being queried
  bool quit_ = false;
  vtkNew<vtkInnerGSPlaneQuery> query_; // the thread's, except for Cancel()
  std::thread thread_;
};

} // namespace innergs::mrml
