#include "Widgets/PlaneExport.h"

#include "Widgets/Host.h"

#include <QApplication>
#include <QClipboard>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QLocale>
#include <QStringList>

#include <vtkMatrix4x4.h>

#include <cmath>
#include <utility>

namespace innergs::ui {

namespace {

constexpr double mostExported = 64e6; // pixels

/// The `innergs slice` command for these pixels of a model file, to paste into a terminal.
QString commandOf(const PlaneTask& task, const QString& modelFile) {
  const auto numbers = [](const Vec3& v) {
    QStringList words;
    for (const double x : v)
      words << QString::number(std::abs(x) < 5e-7 ? 0 : x, 'f', 6);
    return words.join(QLatin1Char(','));
  };
  const Mat3 axes = task.pose.axes();
  // The command's rows run downwards.
  return QStringLiteral("innergs slice \"%1\" --ras --u %2 --v %3 --center %4 --size %5,%6 --spacing %7 "
                        "-o plane.nii.gz")
      .arg(modelFile, numbers(column(axes, 0)), numbers(-1 * column(axes, 1)),
           numbers(task.pose.toRAS(task.left + 0.5 * (task.columns - 1) * task.pixelSize,
                                   task.bottom + 0.5 * (task.rows - 1) * task.pixelSize)))
      .arg(task.columns)
      .arg(task.rows)
      .arg(task.pixelSize, 0, 'g', 6);
}

QString nameOf(const ModelPlane& plane) {
  const QString words[] = {PlaneExport::tr("axial"), PlaneExport::tr("coronal"), PlaneExport::tr("sagittal")};
  const PlanePose& pose = plane.task.pose;
  return PlaneExport::tr("%1 %2 %3 mm")
      .arg(plane.model.name,
           pose.isStraight() ? words[static_cast<int>(pose.orientation)] : PlaneExport::tr("oblique"),
           QLocale().toString(pose.position(), 'f', 1));
}

} // namespace

PlaneExport::PlaneExport(Host* host, PlaneWorker* worker, std::function<ModelPlane()> current,
                         QWidget* parent)
    : QObject(parent), host_(host), worker_(worker), current_(std::move(current)), parent_(parent) {
  connect(worker_, &PlaneWorker::exported, this, &PlaneExport::finish);
}

void PlaneExport::addToVolumes() {
  exportPlane({});
}

void PlaneExport::savePicture() {
  auto* dialog =
      new QFileDialog(parent_, tr("Save the plane as a picture"), host_->folder(), tr("PNG picture (*.png)"));
  dialog->setObjectName(QStringLiteral("queryPictureDialog"));
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix(QStringLiteral("png"));
  dialog->selectFile(nameOf(current_()).replace(QLatin1Char('/'), QLatin1Char('-')) + QStringLiteral(".png"));
  connect(dialog, &QFileDialog::fileSelected, this, [this](const QString& file) {
    host_->setFolder(QFileInfo(file).absolutePath());
    exportPlane(file);
  });
  dialog->open();
}

void PlaneExport::exportPlane(const QString& picture) {
  ModelPlane plane = current_();
  PlaneTask& task = plane.task;
  if (!task.model) return;
  if (static_cast<double>(task.columns) * task.rows > mostExported) {
    Q_EMIT said(tr("The plane would have %1 × %2 pixels: choose a larger pixel size.")
                    .arg(task.columns)
                    .arg(task.rows),
                true);
    return;
  }
  const QString name = nameOf(plane);
  pending_.append({task.uncertainty ? tr("%1, standard deviation").arg(name) : name, plane.modelId});
  task.picture = picture;
  worker_->exportPlane(task);
}

void PlaneExport::finish(const PlaneImage& image) {
  const auto [name, modelId] = pending_.takeFirst();
  const QString file = image.task.picture;
  QString error = QString::fromStdString(image.error);
  if (error.isEmpty() && file.isEmpty()) {
    const std::array<double, 2> window{image.task.lower, image.task.upper};
    host_->addVolumeOf(modelId, window, image.shown(), image.ijkToRAS, name, &error);
    if (error.isEmpty()) Q_EMIT said(tr("'%1' is now among the volumes.").arg(name), false);
  } else if (error.isEmpty()) {
    Q_EMIT said(tr("Saved to '%1'.").arg(QDir::toNativeSeparators(file)), false);
  }
  if (!error.isEmpty()) Q_EMIT said(error, true);
}

void PlaneExport::copyCommand() {
  const auto [task, modelId, model] = current_();
  if (!task.model) return;
  if (task.toModel) {
    Q_EMIT said(tr("The model has been moved by a transform, which a command line does not know: harden the "
                   "transform and save the model first."),
                true);
    return;
  }
  const bool saved = model.saved && !model.file.isEmpty();
  QApplication::clipboard()->setText(commandOf(task, saved ? QDir::toNativeSeparators(model.file)
                                                           : QStringLiteral("%1.innergs").arg(model.name)));
  Q_EMIT said(
      saved ? tr("Copied the plane as a command line (RAS mm).")
            : tr("Copied the plane as a command line (RAS mm); save the model and put its file's name in."),
      false);
}

} // namespace innergs::ui
