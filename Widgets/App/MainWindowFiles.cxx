// Opening, saving, closing.
#include "Widgets/App/MainWindow.h"

#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"
#include "Widgets/SaveDialog.h"

#include <QCloseEvent>
#include <QDir>
#include <QDropEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QLabel>
#include <QMessageBox>
#include <QMimeData>
#include <QPushButton>
#include <QSettings>
#include <QUrl>

#include <algorithm>
#include <utility>

namespace innergs::app {
namespace {

QStringList pathsOf(const QMimeData* data) {
  QStringList paths;
  for (const QUrl& url : data->urls())
    if (url.isLocalFile()) paths << url.toLocalFile();
  return paths;
}

/// A file name from an item's name.
QString fileNameOf(QString name) {
  for (QChar& c : name)
    if (!c.isLetterOrNumber() && !QStringLiteral("-_. ()").contains(c)) c = QLatin1Char('_');
  return name;
}

} // namespace

void MainWindow::open(const QStringList& paths) {
  host_->open(paths);
}

void MainWindow::openFiles() {
  const QStringList files =
      QFileDialog::getOpenFileNames(this, tr("Open volumes or models"), host_->folder(), openFilter());
  if (files.isEmpty()) return;
  host_->setFolder(QFileInfo(files.first()).absolutePath());
  open(files);
}

void MainWindow::openFolder() {
  const QString folder =
      QFileDialog::getExistingDirectory(this, tr("Open the folder of a DICOM series"), host_->folder());
  if (folder.isEmpty()) return;
  host_->setFolder(QFileInfo(folder).absolutePath());
  open({folder});
}

void MainWindow::openSample() {
  if (!sampleBrain().isEmpty()) {
    host_->openSample();
    return;
  }
  auto* box = new QMessageBox(QMessageBox::Information, QStringLiteral("InnerGS"), whatIsTheSampleBrain(),
                              QMessageBox::Cancel, this);
  box->setObjectName(QStringLiteral("sampleBox"));
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  QPushButton* choose = box->addButton(tr("C&hoose File…"), QMessageBox::AcceptRole);
  box->setDefaultButton(choose);
  connect(
      choose, &QPushButton::clicked, this,
      [this] {
        const QString file = QFileDialog::getOpenFileName(
            this, tr("Choose a T1 head with voxels of about 1 mm"), host_->folder(),
            tr("Volumes (*.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd);;All files (*)"));
        if (file.isEmpty()) return;
        host_->setFolder(QFileInfo(file).absolutePath());
        host_->openSample(file);
      },
      Qt::QueuedConnection); // when the box is gone
  box->open();
}

bool MainWindow::saveAs(const QString& id) {
  const auto volume = host_->document().volume(id);
  const auto model = host_->document().model(id);
  if (!volume && !model) return false;
  const QString file = volume ? volume->file : model->file, name = volume ? volume->name : model->name;
  QString end = volume ? QStringLiteral(".nii.gz") : QStringLiteral(".innergs");
  for (const char* known : {".nii", ".nrrd", ".mha"})
    if (volume && file.endsWith(QLatin1String(known), Qt::CaseInsensitive)) end = QString::fromLatin1(known);
  ui::SaveDialog dialog(this, volume ? tr("Save '%1'").arg(name) : tr("Save model '%1'").arg(name),
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
  addRecentFile(to);
  fillRecent();
  const auto after = host_->document().model(id);
  if (!after || after->saved || !isPly(to)) return true;
  tell(tr("'%1' holds only the Gaussians, without the residual grid and the state of the fit: save the model "
          "as .innergs as well to keep everything.")
           .arg(QFileInfo(to).fileName()));
  return false;
}

void MainWindow::tell(const QString& sentence) {
  auto* box =
      new QMessageBox(QMessageBox::Warning, QStringLiteral("InnerGS"), sentence, QMessageBox::Ok, this);
  box->setObjectName(QStringLiteral("errorBox"));
  box->setAttribute(Qt::WA_DeleteOnClose);
  box->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  box->open();
}

void MainWindow::tellErrors() {
  if (!errors_.isEmpty()) tell(std::exchange(errors_, {}).join(QStringLiteral("\n\n")));
}

void MainWindow::closeItem(const QString& id) {
  if (host_->document().unsaved().contains(id)) {
    QMessageBox box(QMessageBox::Question, QStringLiteral("InnerGS"),
                    tr("'%1' is not saved. Save it before it is closed?").arg(host_->document().nameOf(id)),
                    QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, this);
    box.setObjectName(QStringLiteral("closeItemBox"));
    box.setDefaultButton(QMessageBox::Save);
    const int answer = box.exec();
    if (answer == QMessageBox::Cancel || (answer == QMessageBox::Save && !saveAs(id))) return;
  }
  host_->document().remove(id);
}

bool MainWindow::mayDiscard() {
  const Document& document = host_->document();
  const QStringList ids = document.unsaved();
  if (ids.isEmpty()) return true;
  QStringList names;
  for (const QString& id : ids)
    names << document.nameOf(id);
  QMessageBox box(QMessageBox::Question, QStringLiteral("InnerGS"),
                  tr("These results are not saved and will be lost:\n%1").arg(names.join(QLatin1Char('\n'))),
                  QMessageBox::SaveAll | QMessageBox::Discard | QMessageBox::Cancel, this);
  box.setObjectName(QStringLiteral("unsavedBox"));
  box.setDefaultButton(QMessageBox::SaveAll);
  const int answer = box.exec();
  if (answer != QMessageBox::SaveAll) return answer == QMessageBox::Discard;
  return std::all_of(ids.begin(), ids.end(), [this](const QString& id) { return saveAs(id); });
}

void MainWindow::closeEvent(QCloseEvent* event) {
  event->ignore();
  if (closeWhenEnded_) return;
  if (host_->background().isBusy()) {
    if (closeWhenIdle_) return;
    closeWhenIdle_ = true;
    busyBox_ = new QMessageBox(QMessageBox::Information, QStringLiteral("InnerGS"),
                               tr("A file is being read or written. The window closes when that is done."),
                               QMessageBox::NoButton, this);
    busyBox_->setObjectName(QStringLiteral("busyBox"));
    busyBox_->setAttribute(Qt::WA_DeleteOnClose);
    QPushButton* stay = busyBox_->addButton(tr("&Keep Open"), QMessageBox::RejectRole);
    busyBox_->setDefaultButton(stay);
    busyBox_->setEscapeButton(stay);
    connect(busyBox_, &QMessageBox::finished, this, [this] { closeWhenIdle_ = false; });
    busyBox_->open();
    return;
  }
  if (host_->isRunning()) {
    auto* box =
        new QMessageBox(QMessageBox::Question, QStringLiteral("InnerGS"),
                        tr("A reconstruction is running. Stop it and close?"), QMessageBox::NoButton, this);
    box->setObjectName(QStringLiteral("runningBox"));
    box->setAttribute(Qt::WA_DeleteOnClose);
    QPushButton* stop = box->addButton(tr("&Stop and Close"), QMessageBox::DestructiveRole);
    QPushButton* stay = box->addButton(tr("&Keep Running"), QMessageBox::RejectRole);
    box->setDefaultButton(stay);
    box->setEscapeButton(stay);
    connect(stop, &QPushButton::clicked, this, [this] {
      closeWhenEnded_ = true;
      host_->cancel();
      if (!host_->isRunning()) reconstructionEnded();
    });
    box->open();
    return;
  }
  if (!mayDiscard()) return;
  const auto settings = appSettings();
  settings->setValue(QStringLiteral("window/geometry"), saveGeometry());
  settings->setValue(QStringLiteral("window/state"), saveState());
  settings->setValue(QStringLiteral("window/layout"), static_cast<int>(views_->layoutShown()));
  event->accept();
}

void MainWindow::reconstructionEnded() {
  if (!closeWhenEnded_) return;
  closeWhenEnded_ = false;
  // A result finished before the stop is asked about like any other.
  QMetaObject::invokeMethod(
      this, [this] { close(); }, Qt::QueuedConnection);
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (!pathsOf(event->mimeData()).isEmpty()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QStringList paths = pathsOf(event->mimeData());
  if (paths.isEmpty()) return;
  event->acceptProposedAction();
  open(paths);
}

} // namespace innergs::app
