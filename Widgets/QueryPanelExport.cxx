#include "Widgets/PlaneView.h"
#include "Widgets/QueryPanel.h"

#include <QApplication>
#include <QClipboard>
#include <QDir>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QLocale>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <cmath>

/// The plane as a volume of the host's, or as a picture.

namespace innergs::ui {

constexpr double mostKept = 64e6; // pixels

QString QueryPanel::planeName() const {
  const QString words[] = {tr("axial"), tr("coronal"), tr("sagittal")};
  return tr("%1 %2 %3 mm")
      .arg(info_.name, pose_.isStraight() ? words[static_cast<int>(pose_.orientation)] : tr("oblique"),
           QLocale().toString(pose_.position(), 'f', 1));
}

void QueryPanel::keep(const QString& file) {
  if (!model_) return;
  PlaneTask task = taskFor(pixelSize_->value());
  if (static_cast<double>(task.columns) * task.rows > mostKept) {
    say(tr("The plane would have %1 × %2 pixels: choose a larger pixel size.")
            .arg(task.columns)
            .arg(task.rows),
        true);
    return;
  }
  kept_.append({planeName(), modelId_});
  task.picture = file;
  task.lower = view_->lower();
  task.upper = view_->upper();
  worker_->keep(task);
}

void QueryPanel::kept(const PlaneImage& image) {
  const auto [name, modelId] = kept_.takeFirst();
  const QString file = image.task.picture;
  QString error = image.error;
  if (error.isEmpty() && file.isEmpty()) {
    const std::array<double, 2> window{image.task.lower, image.task.upper};
    host_->addVolumeOf(modelId, window, image.image, image.ijkToRAS, name, &error);
    if (error.isEmpty()) say(tr("“%1” is now among the volumes.").arg(name));
  } else if (error.isEmpty()) {
    say(tr("Saved to “%1”.").arg(QDir::toNativeSeparators(file)));
  }
  if (!error.isEmpty()) say(error, true);
}

QString commandOf(const PlaneTask& task, const QString& modelFile) {
  const auto numbers = [](const Vec3& v) {
    QStringList words;
    for (const double x : v)
      words << QString::number(std::abs(x) < 5e-7 ? 0 : x, 'f', 6);
    return words.join(QLatin1Char(','));
  };
  const Mat3 axes = task.pose.axes();
  // The command's rows run down.
  return QStringLiteral("innergs slice \"%1\" --ras --u %2 --v %3 --center %4 --size %5,%6 --spacing %7 "
                        "-o plane.nii.gz")
      .arg(modelFile, numbers(column(axes, 0)), numbers(-1 * column(axes, 1)),
           numbers(task.pose.toRAS(task.left + 0.5 * (task.columns - 1) * task.pixelSize,
                                   task.bottom + 0.5 * (task.rows - 1) * task.pixelSize)))
      .arg(task.columns)
      .arg(task.rows)
      .arg(task.pixelSize, 0, 'g', 6);
}

void QueryPanel::copyCommand() {
  if (!model_) return;
  if (toModel_)
    return say(tr("The model has been moved by a transform, which a command line does not know: harden the "
                  "transform and save the model first."),
               true);
  const bool saved = info_.saved && !info_.file.isEmpty();
  QApplication::clipboard()->setText(
      commandOf(taskFor(pixelSize_->value()),
                saved ? QDir::toNativeSeparators(info_.file) : QStringLiteral("%1.innergs").arg(info_.name)));
  say(saved ? tr("Copied the plane as a command line (RAS mm).")
            : tr("Copied the plane as a command line (RAS mm); save the model and put its file's name in."));
}

void QueryPanel::choosePictureFile() {
  auto* dialog =
      new QFileDialog(this, tr("Save the plane as a picture"), host_->folder(), tr("PNG picture (*.png)"));
  dialog->setObjectName(QStringLiteral("queryPictureDialog"));
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setAcceptMode(QFileDialog::AcceptSave);
  dialog->setDefaultSuffix(QStringLiteral("png"));
  dialog->selectFile(planeName().replace(QLatin1Char('/'), QLatin1Char('-')) + QStringLiteral(".png"));
  connect(dialog, &QFileDialog::fileSelected, this, [this](const QString& file) {
    host_->setFolder(QFileInfo(file).absolutePath());
    keep(file);
  });
  dialog->open();
}

} // namespace innergs::ui
