#include "Widgets/PlaneView.h"
#include "Widgets/QueryPanel.h"

#include <QDir>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QFileInfo>
#include <QLocale>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

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
