#include "Widgets/PlaneWorker.h"

#include "Core/Base/Failure.h"
#include "Core/Job/ReconstructionJob.h"
#include "Widgets/PlanePicture.h"

#include "vtkInnerGSModel.h"
#include "vtkInnerGSPlaneQuery.h"

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace innergs::ui {

struct PlaneWorker::Work {
  std::mutex mutex; // for the following members
  std::condition_variable wake;
  std::optional<PlaneTask> plane, point;
  std::deque<PlaneTask> toExport;
  bool stopping = false;
  bool showing = false;               // the query is computing a plane to show
  vtkNew<vtkInnerGSPlaneQuery> query; // used only by the thread, except for Cancel()
  std::shared_ptr<const Model> queried;
  std::shared_ptr<const UncertaintyVolume> queriedUncertainty;
  std::thread thread;

  /// Called on the thread. Waits for a task; returns false at the end.
  bool next(PlaneTask& task, Signal& signal) {
    std::unique_lock lock(mutex);
    wake.wait(lock, [this] { return stopping || point || plane || !toExport.empty(); });
    if (stopping) return false;
    if (point) {
      task = *std::exchange(point, std::nullopt);
      signal = &PlaneWorker::probed;
    } else if (plane) {
      task = *std::exchange(plane, std::nullopt);
      signal = &PlaneWorker::shown;
      showing = true;
    } else {
      task = toExport.front();
      toExport.pop_front();
      signal = &PlaneWorker::exported;
    }
    return true;
  }

  PlaneImage run(const PlaneTask& task) {
    PlaneImage result;
    result.task = task;
    result.ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
    try {
      if (queried != task.model) { // a separate data object for the thread, which shares the Gaussians
        vtkNew<vtkInnerGSModel> model;
        model->SetCoreModel(task.model);
        query->SetModel(model);
        queried = task.model;
      }
      PlanePose corner = task.pose;
      corner.move(task.left, task.bottom, 0);
      vtkNew<vtkMatrix4x4> matrix;
      toMatrix(corner, matrix);
      if (queriedUncertainty != task.uncertainty) {
        vtkNew<vtkImageData> own; // with information of its own, the voxels are shared
        if (task.uncertainty) own->ShallowCopy(task.uncertainty->image);
        query->SetStandardDeviationData(task.uncertainty ? own.Get() : nullptr);
        query->SetStandardDeviationIJKToRASMatrix(task.uncertainty ? task.uncertainty->ijkToRAS.Get()
                                                                   : nullptr);
        queriedUncertainty = task.uncertainty;
      }
      query->SetTransformToModel(task.toModel);
      query->SetPlaneToRASMatrix(matrix);
      query->SetSpacing(task.pixelSize, task.pixelSize);
      query->SetDimensions(task.columns, task.rows);
      result.image = query->Query();
      result.error = QString::fromStdString(query->GetErrorMessage());
      if (!result.image) return result;
      if (task.uncertainty) {
        result.deviation = vtkSmartPointer<vtkImageData>::New();
        result.deviation->ShallowCopy(query->GetOutputStandardDeviation());
      }
      result.ijkToRAS->DeepCopy(query->GetOutputIJKToRASMatrix());
      result.milliseconds = query->GetQueryMilliseconds();
      if (task.columns == 1 && task.rows == 1) {
        Vec3 at = corner.origin;
        if (task.toModel) task.toModel->TransformPoint(at.data(), at.data());
        result.inside = query->GetModel()->IsInside(at[0], at[1], at[2]);
      }
      if (!task.picture.isEmpty()) result.error = savePicture(result, task.lower, task.upper, task.picture);
    } catch (...) {
      result.image = nullptr;
      result.error = QString::fromStdString(failureOf().sentence);
    }
    return result;
  }

  void loop(PlaneWorker* owner) {
    PlaneTask task;
    Signal signal = nullptr;
    while (next(task, signal)) {
      const PlaneImage result = run(task);
      {
        std::lock_guard lock(mutex);
        showing = false;
        if (stopping) return;
        if (!result.image && result.error.isEmpty()) { // stopped: repeats it unless there is something newer
          if (signal == &PlaneWorker::shown && !plane) plane = task;
          if (signal == &PlaneWorker::probed && !point) point = task;
          if (signal == &PlaneWorker::exported) toExport.push_front(task);
          continue;
        }
      }
      QMetaObject::invokeMethod(
          owner,
          [owner, signal, result] {
            Q_EMIT(owner->*signal)
            (result);
          },
          Qt::QueuedConnection);
    }
  }
};

PlaneWorker::PlaneWorker(QObject* parent) : QObject(parent), work_(std::make_unique<Work>()) {
  work_->query->CentredOff();
  work_->query->GeometryInImageOff();
  vtkNew<vtkCallbackCommand> silent; // the results carry the errors
  silent->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  work_->query->AddObserver(vtkCommand::ErrorEvent, silent);
}

bool PlaneWorker::start(const PlaneTask& task, Signal signal) {
  if (work_->thread.joinable()) return true;
  PlaneImage none;
  none.task = task;
  none.error =
      QString::fromStdString(sentenceOf([&] { work_->thread = std::thread([this] { work_->loop(this); }); }));
  if (none.error.isEmpty()) return true;
  QMetaObject::invokeMethod(
      this,
      [this, signal, none] {
        Q_EMIT(this->*signal)
        (none);
      },
      Qt::QueuedConnection);
  return false;
}

PlaneWorker::~PlaneWorker() {
  {
    std::lock_guard lock(work_->mutex);
    work_->stopping = true;
    work_->query->Cancel();
  }
  work_->wake.notify_one();
  if (work_->thread.joinable()) work_->thread.join();
}

void PlaneWorker::show(const PlaneTask& task, bool hurry) {
  if (!start(task, &PlaneWorker::shown)) return;
  {
    std::lock_guard lock(work_->mutex);
    work_->plane = task;
    if (hurry && work_->showing) work_->query->Cancel();
  }
  work_->wake.notify_one();
}

void PlaneWorker::probe(const PlaneTask& task) {
  if (!start(task, &PlaneWorker::probed)) return;
  {
    std::lock_guard lock(work_->mutex);
    work_->point = task;
    work_->point->columns = work_->point->rows = 1;
  }
  work_->wake.notify_one();
}

void PlaneWorker::exportPlane(const PlaneTask& task) {
  if (!start(task, &PlaneWorker::exported)) return;
  {
    std::lock_guard lock(work_->mutex);
    work_->toExport.push_back(task);
  }
  work_->wake.notify_one();
}

void PlaneWorker::clear() {
  std::lock_guard lock(work_->mutex);
  work_->plane.reset();
  work_->point.reset();
}

} // namespace innergs::ui
