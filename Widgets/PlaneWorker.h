#pragma once
#include "Widgets/PlanePose.h"

#include <QMetaType>
#include <QObject>
#include <QString>

#include <vtkAbstractTransform.h>
#include <vtkSmartPointer.h>

#include <memory>

class vtkImageData;
class vtkMatrix4x4;

namespace innergs {
struct Model;
}

namespace innergs::ui {

/// Pixels on a plane of a model.
struct PlaneTask {
  std::shared_ptr<const Model> model;
  vtkSmartPointer<vtkAbstractTransform> toModel; // as Host::toModel()
  PlanePose pose;
  double left = 0, bottom = 0; // centre of pixel (0, 0) in plane coordinates, mm
  double pixelSize = 1;        // mm
  int columns = 1, rows = 1;
  QString picture;             // a PNG file to write as well; "" none
  double lower = 0, upper = 1; // black and white in it
};

/// `innergs slice` with these pixels, of a model file: what a person can paste into a terminal.
QString commandOf(const PlaneTask& task, const QString& modelFile);

struct PlaneImage {
  PlaneTask task;
  vtkSmartPointer<vtkImageData> image;    // float, scanner units; origin 0, spacing 1; null after an error
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // of the image
  QString error;                          // a sentence; also when the picture was not written
  double milliseconds = 0;                // that the query took
  bool inside = true;                     // of a probe: the model has a value there
};

/// Queries planes on a thread of its own. What is shown and probed follows the latest request, and requests
/// in between are skipped; every export is done. Signals come on the thread that the object lives in.
class PlaneWorker : public QObject {
  Q_OBJECT
public:
  explicit PlaneWorker(QObject* parent = nullptr);
  ~PlaneWorker() override;

  /// hurry: stops the query in progress, because this one will be much faster.
  void show(const PlaneTask& task, bool hurry = false);
  /// The model's value at a point: pixel (0, 0) of the task.
  void probe(const PlaneTask& task);
  /// In full, e.g. to export it.
  void exportPlane(const PlaneTask& task);
  /// Drops what has not begun, except exports.
  void clear();

Q_SIGNALS:
  void shown(const innergs::ui::PlaneImage& image);
  void probed(const innergs::ui::PlaneImage& point);
  void exported(const innergs::ui::PlaneImage& image);

private:
  using Signal = void (PlaneWorker::*)(const PlaneImage&);
  /// With the first task; false after telling, by the signal, why there is no thread.
  bool start(const PlaneTask& task, Signal signal);
  struct Work;
  std::unique_ptr<Work> work_;
};

} // namespace innergs::ui

Q_DECLARE_METATYPE(innergs::ui::PlaneImage)
