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

struct PlaneImage {
  PlaneTask task;
  vtkSmartPointer<vtkImageData> image;     // float, scanner units; origin 0, spacing 1; null after an error
  vtkSmartPointer<vtkImageData> deviation; // likewise, with what was measured (UncertaintyImage.h); null: not
                                           // asked for
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS;  // of the images; null after an error
  QString error;                           // a sentence; also if the picture was not written
  double milliseconds = 0;                 // duration of the query
  bool inside = true;                      // for a probe: whether the model has a value there

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
