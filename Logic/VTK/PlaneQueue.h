#pragma once
#include "vtkInnerGSExport.h"

#include "vtkAbstractTransform.h"
#include "vtkImageData.h"
#include "vtkMatrix4x4.h"
#include "vtkNew.h"
#include "vtkSmartPointer.h"

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

class vtkInnerGSPlaneQuery;

namespace innergs {

struct Model;

/// Pixels on a plane of a model. Nobody changes its objects once it is requested.
struct PlaneRequest {
  std::shared_ptr<const Model> model;
  vtkSmartPointer<vtkAbstractTransform> toModel; // RAS → the model's RAS; null: identity
  vtkSmartPointer<vtkMatrix4x4> planeToRAS;      // its origin is the centre of pixel (0, 0)
  int columns = 1, rows = 1;
  double spacing = 1; // of the pixels, in the plane's own units
  vtkSmartPointer<vtkImageData>
      deviation; // queried as well: the standard deviation in the model's RAS; null: not
  vtkSmartPointer<vtkMatrix4x4> deviationIJKToRAS;
};

struct QueriedPlane {
  vtkSmartPointer<vtkImageData> image;     // float, scanner units; origin 0, spacing 1; null after an error
  vtkSmartPointer<vtkImageData> deviation; // likewise, with what was measured (UncertaintyImage.h); null: not
                                           // asked for
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS;  // of the images
  std::string error;                       // a sentence; "": none
  double milliseconds = 0;                 // duration of the query
};

/// Queries planes on a thread of its own.
class VTKINNERGS_EXPORT PlaneQueue {
public:
  using Answer = std::function<void(const QueriedPlane&)>; // called on the thread
  /// background: with low priority, and without keeping the last model.
  explicit PlaneQueue(bool background = false);
  /// Stops the current query. No answer follows.
  ~PlaneQueue();
  PlaneQueue(const PlaneQueue&) = delete;
  PlaneQueue& operator=(const PlaneQueue&) = delete;

  /// Replaces the waiting request of the same key; those with lower keys are carried out first. rest: time
  /// to wait before. Throws std::system_error if the system cannot start a thread.
  void request(int key, PlaneRequest request, Answer answer, std::chrono::milliseconds rest = {});
  /// Stops the query of this key, if it is the current one, and puts it back unless a request of the same key
  /// waits.
  void interrupt(int key);
  /// Forgets the waiting request of this key.
  void drop(int key);

private:
  using Clock = std::chrono::steady_clock;
  struct Waiting {
    PlaneRequest request;
    Answer answer;
    Clock::time_point due;
  };
  void work();
  QueriedPlane query(const PlaneRequest& request);

  const bool background_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<int, Waiting> waiting_;
  std::optional<int> current_; // key of the request being queried
  bool quit_ = false;
  std::shared_ptr<const Model> queried_;
  vtkNew<vtkInnerGSPlaneQuery> query_; // the thread's, except for Cancel()
  std::thread thread_;
};

} // namespace innergs
