#pragma once
#include "PlaneQueue.h"
#include "Widgets/PlanePose.h"
#include "Widgets/UncertaintyVolume.h"

#include <QMetaType>
#include <QObject>
#include <QString>

#include <vtkAbstractTransform.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkSmartPointer.h>

#include <memory>

namespace innergs::ui {

/// Pixels on a plane of a model.
struct PlaneTask {
  std::shared_ptr<const Model> model;
  vtkSmartPointer<vtkAbstractTransform> toModel;        // see Host::toModel()
  std::shared_ptr<const UncertaintyVolume> uncertainty; // queried as well; null: not
  PlanePose pose;
  double left = 0, bottom = 0; // centre of pixel (0, 0) in plane coordinates, mm
  double pixelSize = 1;        // mm
  int columns = 1, rows = 1;
  QString picture;             // also writes this PNG file; "" none
  double lower = 0, upper = 1; // shown as black and white in it
};

struct PlaneImage : QueriedPlane { // its error also says if the picture was not written
  PlaneTask task;
  bool inside = true; // for a probe: whether the model has a value there

  /// What is shown of it: the deviation where it was asked for.
  vtkImageData* shown() const { return deviation ? deviation : image; }
};

/// Queries planes on a separate thread. Showing and probing follow the latest request and skip those in
/// between; every export is carried out. Signals arrive on the thread that the object lives in.
class PlaneWorker : public QObject {
  Q_OBJECT
public:
  explicit PlaneWorker(QObject* parent = nullptr);
  ~PlaneWorker() override;

  /// hurry: stops the current query, because this one will be much faster.
  void show(const PlaneTask& task, bool hurry = false);
  /// Queries the model's value at a point: pixel (0, 0) of the task.
  void probe(const PlaneTask& task);
  /// Queries in full resolution, e.g. for an export.
  void exportPlane(const PlaneTask& task);
  /// Drops what has not started, except exports.
  void clear();

Q_SIGNALS:
  void shown(const innergs::ui::PlaneImage& image);
  void probed(const innergs::ui::PlaneImage& point);
  void exported(const innergs::ui::PlaneImage& image);

private:
  using Signal = void (PlaneWorker::*)(const PlaneImage&);
  void start(int key, const PlaneTask& task, Signal signal);
  /// Emits the signal once the event loop is reached; called on any thread.
  void post(Signal signal, const PlaneImage& image);

  int nextExport_; // its key in the queue
  PlaneQueue queue_;
};

} // namespace innergs::ui

Q_DECLARE_METATYPE(innergs::ui::PlaneImage)
