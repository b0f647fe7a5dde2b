#include "Widgets/App/FileDialogs.h"

#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"
#include "Widgets/SaveDialog.h"

#include <QFileDialog>
#include <QFileInfo>
#include <QMessageBox>
#include <QPushButton>

#include <algorithm>

namespace innergs::app {
namespace {

/// A file name from an item's name.
QString fileNameOf(QString name) {
  for (QChar& c : name)
    if (!c.isLetterOrNumber() && !QStringLiteral("-_. ()").contains(c)) c = QLatin1Char('_');
  return name;
}

} // namespace

FileDialogs::FileDialogs(AppHost* host, QWidget* window) : QObject(window), host_(host), window_(window) {}

void FileDialogs::openFiles() {
  const QStringList files =
      QFileDialog::getOpenFileNames(window_, tr("Open volumes or models"), host_->folder(), openFilter());
  if (files.isEmpty()) return;
  host_->setFolder(QFileInfo(files.first()).absolutePath());
  host_->open(files);
}

void FileDialogs::openFolder() {
  const QString folder = QFileDialog::getExistingDirectory(
      window_, tr("Open the folder of a DICOM series or of frames with times.txt"), host_->folder());
  if (folder.isEmpty()) return;
  host_->setFolder(QFileInfo(folder).absolutePath());
  host_->open({folder});
}

void FileDialogs::openSample() {
  if (!sampleBrain().isEmpty()) {
    host_->openSample();
    return;
  }
  offerFile(QStringLiteral("sampleBox"), whatIsTheSampleBrain(),
            tr("Choose a T1 head with voxels of about 1 mm"),
            tr("Volumes (*.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd);;All files (*)"),
            [this](const QString& file) { host_->openSample(file); });
}

void FileDialogs::askCalibration(const QString& id) {
  const auto item = host_->document().volume(id);
  if (!item || item->unplaced.isEmpty()) return;
  offerFile(QStringLiteral("calibrationBox"), item->unplaced,
            tr("Choose the calibration of '%1'").arg(item->name),
            tr("Calibrations (*.xml *.txt);;All files (*)"),
            [this, id](const QString& file) { host_->calibrate(id, file); });
}

void FileDialogs::offerFile(const QString& name, const QString& sentence, const QString& title,
                            const QString& filter, const std::function<void(const QString&)>& chosen) {
  auto* box = new QMessageBox(QMessageBox::Information, QStringLiteral("InnerGS"), sentence,
                              QMessageBox::Cancel, window_);
  box->setObjectName(name);
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  QPushButton* choose = box->addButton(tr("C&hoose File…"), QMessageBox::AcceptRole);
  box->setDefaultButton(choose);
  connect(
      choose, &QPushButton::clicked, this,
      [this, title, filter, chosen] {
        const QString file = QFileDialog::getOpenFileName(window_, title, host_->folder(), filter);
        if (file.isEmpty()) return;
        host_->setFolder(QFileInfo(file).absolutePath());
        chosen(file);
      },
      Qt::QueuedConnection); // after the box has closed
  box->open();
}

bool FileDialogs::saveAs(const QString& id) {
  const auto volume = host_->document().volume(id);
  const auto model = host_->document().model(id);
  if (!volume && !model) return false;
  const QString file = volume ? volume->file : model->file, name = volume ? volume->name : model->name;
  QString end = volume ? QStringLiteral(".nii.gz") : QStringLiteral(".innergs");
  for (const char* known : {".nii", ".nrrd", ".mha"})
    if (volume && file.endsWith(QLatin1String(known), Qt::CaseInsensitive)) end = QString::fromLatin1(known);
  ui::SaveDialog dialog(window_, volume ? tr("Save '%1'").arg(name) : tr("Save model '%1'").arg(name),
                        host_->folder(), volume ? volumeFilter() : modelFilter(), fileNameOf(name) + end);
  dialog.setObjectName(QStringLiteral("saveDialog"));
  if (dialog.exec() != QDialog::Accepted || dialog.selectedFiles().isEmpty()) return false;
  const QString to = dialog.complete(dialog.selectedFiles().first());
  if (to.isEmpty()) return false;
  host_->setFolder(QFileInfo(to).absolutePath());
  const QString sentence = host_->save(id, to);
  if (!sentence.isEmpty()) {
    tell(sentence);
    return false;
  }
  Q_EMIT saved(to);
  const auto after = host_->document().model(id);
  if (!after || after->saved || !isPly(to)) return true;
  tell(tr("'%1' holds only the Gaussians, without the residual grid and the state of the fit: save the model "
          "as .innergs as well to keep everything.")
           .arg(QFileInfo(to).fileName()));
  return false;
}

void FileDialogs::tell(const QString& sentence) {
  auto* box =
      new QMessageBox(QMessageBox::Warning, QStringLiteral("InnerGS"), sentence, QMessageBox::Ok, window_);
  box->setObjectName(QStringLiteral("errorBox"));
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  box->open();
}

void FileDialogs::closeItem(const QString& id) {
  if (host_->document().unsaved().contains(id)) {
    QMessageBox box(QMessageBox::Question, QStringLiteral("InnerGS"),
                    tr("Save '%1' before closing it?").arg(host_->document().nameOf(id)),
                    QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, window_);
    box.setObjectName(QStringLiteral("closeItemBox"));
    box.setDefaultButton(QMessageBox::Save);
    const int answer = box.exec();
    if (answer == QMessageBox::Cancel || (answer == QMessageBox::Save && !saveAs(id))) return;
  }
  host_->document().remove(id);
}

bool FileDialogs::mayDiscard() {
  const Document& document = host_->document();
  const QStringList ids = document.unsaved();
  if (ids.isEmpty()) return true;
  QStringList names;
  for (const QString& id : ids)
    names << document.nameOf(id);
  QMessageBox box(QMessageBox::Question, QStringLiteral("InnerGS"),
                  tr("These results are not saved and will be lost:\n%1").arg(names.join(QLatin1Char('\n'))),
                  QMessageBox::SaveAll | QMessageBox::Discard | QMessageBox::Cancel, window_);
  box.setObjectName(QStringLiteral("unsavedBox"));
  box.setDefaultButton(QMessageBox::SaveAll);
  const int answer = box.exec();
  if (answer != QMessageBox::SaveAll) return answer == QMessageBox::Discard;
  return std::all_of(ids.begin(), ids.end(), [this](const QString& id) { return saveAs(id); });
}

} // namespace innergs::app
