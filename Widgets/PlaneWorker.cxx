#include "Widgets/PlaneWorker.h"

#include "Core/Base/Failure.h"
#include "Widgets/PlanePicture.h"

#include "vtkInnerGSModel.h"

#include <vtkNew.h>

namespace innergs::ui {

namespace {

// In the order in which waiting ones are carried out.
constexpr int kProbe = 0, kShow = 1, kFirstExport = 2;

PlanePose cornerOf(const PlaneTask& task) {
  PlanePose corner = task.pose;
  corner.move(task.left, task.bottom, 0);
  return corner;
}

PlaneRequest requestFor(const PlaneTask& task) {
  PlaneRequest request;
  request.model = task.model;
  request.toModel = task.toModel;
  request.planeToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  toMatrix(cornerOf(task), request.planeToRAS);
  request.columns = task.columns;
  request.rows = task.rows;
  request.spacing = task.pixelSize;
  if (task.uncertainty) {
    request.deviation = task.uncertainty->image;
    request.deviationIJKToRAS = task.uncertainty->ijkToRAS;
  }
  return request;
}

bool isInside(const PlaneTask& task) {
  Vec3 at = cornerOf(task).origin;
  if (task.toModel) task.toModel->TransformPoint(at.data(), at.data());
  vtkNew<vtkInnerGSModel> model;
  model->SetCoreModel(task.model);
  return model->IsInside(at[0], at[1], at[2]);
}

PlaneImage imageOf(const PlaneTask& task, const QueriedPlane& plane) {
  PlaneImage image{plane, task};
  if (!plane.image) return image;
  if (task.columns == 1 && task.rows == 1) image.inside = isInside(task);
  if (!task.picture.isEmpty())
    image.error = savePicture(image, task.lower, task.upper, task.picture).toStdString();
  return image;
}

PlaneImage failedImage(const PlaneTask& task, const std::string& error) {
  PlaneImage image;
  image.task = task;
  image.error = error;
  return image;
}

} // namespace

PlaneWorker::PlaneWorker(QObject* parent) : QObject(parent), nextExport_(kFirstExport) {}

PlaneWorker::~PlaneWorker() = default;

void PlaneWorker::post(Signal signal, const PlaneImage& image) {
  QMetaObject::invokeMethod(
      this,
      [this, signal, image] {
        Q_EMIT(this->*signal)
        (image);
      },
      Qt::QueuedConnection);
}

void PlaneWorker::start(int key, const PlaneTask& task, Signal signal) {
  const auto answer = [this, task, signal](const QueriedPlane& plane) {
    PlaneImage image;
    const std::string error = sentenceOf([&] { image = imageOf(task, plane); });
    post(signal, error.empty() ? image : failedImage(task, error));
  };
  const std::string error = sentenceOf([&] { queue_.request(key, requestFor(task), answer); });
  if (!error.empty()) post(signal, failedImage(task, error));
}

void PlaneWorker::show(const PlaneTask& task, bool hurry) {
  start(kShow, task, &PlaneWorker::shown);
  if (hurry) queue_.interrupt(kShow);
}

void PlaneWorker::probe(const PlaneTask& task) {
  PlaneTask point = task;
  point.columns = point.rows = 1;
  start(kProbe, point, &PlaneWorker::probed);
}

void PlaneWorker::exportPlane(const PlaneTask& task) {
  start(nextExport_++, task, &PlaneWorker::exported);
}

void PlaneWorker::clear() {
  queue_.drop(kShow);
  queue_.drop(kProbe);
}

} // namespace innergs::ui
