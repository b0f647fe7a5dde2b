#include "Widgets/SlicesLine.h"

#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/SlicesDialog.h"

#include <vtkTable.h>

#include <QDir>
#include <QFileDialog>
#include <QHBoxLayout>
#include <QMessageBox>
#include <QPushButton>
#include <QVBoxLayout>

namespace innergs::ui {

SlicesLine::SlicesLine(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), show_(new QPushButton(tr("Show Slices…"), this)),
      create_(new QPushButton(tr("Create Slice Transforms"), this)), message_(new MessageLine(this)) {
  show_->setObjectName(QStringLiteral("showSlices"));
  create_->setObjectName(QStringLiteral("createSliceTransforms"));
  if (host->keepsSlicesInFiles()) create_->setText(tr("Create Slice Transforms…")); // it asks where
  message_->setObjectName(QStringLiteral("slicesMessage"));
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(show_);
  buttons->addWidget(create_);
  buttons->addStretch(1);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addLayout(buttons);
  layout->addWidget(message_);
  connect(show_, &QPushButton::clicked, this, &SlicesLine::showTable);
  connect(create_, &QPushButton::clicked, this, &SlicesLine::createTransforms);
  connect(host, &Host::started, this, &SlicesLine::refresh);
  connect(host, &Host::finished, this, &SlicesLine::refresh);
  connect(host, &Host::failed, this, &SlicesLine::refresh);
  connect(host, &Host::cancelled, this, &SlicesLine::refresh);
  connect(host, &Host::ended, this, &SlicesLine::refresh);
  connect(host, &Host::modelsChanged, this, &SlicesLine::refresh);
  refresh();
}

void SlicesLine::refresh() {
  vtkTable* const slices = host_->sliceTable();
  if (slices != slices_) {
    message_->clear();
    delete dialog_;
  }
  slices_ = slices;
  const bool moved = slices != nullptr;
  show_->setEnabled(moved);
  create_->setEnabled(moved);
  show_->setToolTip(moved ? tr("List where each slice lies and how well it fits the other scans.")
                          : tr("Nothing to show: no slice was moved."));
  create_->setToolTip(!moved ? tr("Nothing to create: no slice was moved.")
                      : host_->keepsSlicesInFiles()
                          ? tr("Write an ITK transform (.tfm) per slice to a folder.")
                          : tr("Make a transform node per slice, in a folder of the subject hierarchy."));
  setVisible(host_->hasResult() && !host_->isRunning());
}

void SlicesLine::showTable() {
  dialog_ = new SlicesDialog(slices_, host_->keepsSlicesInFiles(), this);
  dialog_->setAttribute(Qt::WA_DeleteOnClose);
  connect(dialog_, &SlicesDialog::saveRequested, this, &SlicesLine::saveTable);
  dialog_->open();
}

void SlicesLine::saveTable() {
  askWhereToSave(
      dialog_, host_, "saveSlicesDialog", tr("Save the table of slices"), tr("Tab-separated values (*.tsv)"),
      QStringLiteral("slices.tsv"), [this](const QString& file) {
        say(tr("Saved the table to '%1'.").arg(QDir::toNativeSeparators(file)), host_->saveSliceTable(file));
      });
}

void SlicesLine::createTransforms() {
  if (!host_->keepsSlicesInFiles()) return createIn({});
  auto* dialog =
      named(new QFileDialog(this, tr("Folder for the transforms"), host_->folder()), "transformsDialog");
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  dialog->setFileMode(QFileDialog::Directory);
  dialog->setOption(QFileDialog::ShowDirsOnly);
  connect(dialog, &QFileDialog::fileSelected, this, &SlicesLine::createIn);
  dialog->open();
}

void SlicesLine::createIn(const QString& folder) {
  if (!folder.isEmpty()) {
    host_->setFolder(folder);
    const bool there = !QDir(folder).entryList({QStringLiteral("scan-*-slice-*.tfm")}).isEmpty();
    if (there &&
        QMessageBox::question(this, tr("Slice transforms"),
                              tr("'%1' holds transforms of slices already. Replace those of the same name?")
                                  .arg(QDir::toNativeSeparators(folder))) != QMessageBox::Yes)
      return;
  }
  QString error;
  const QString done = host_->createSliceTransforms(folder, &error);
  say(done, error);
}

void SlicesLine::say(const QString& done, const QString& error) {
  message_->say(error.isEmpty() ? done : error, !error.isEmpty());
}

} // namespace innergs::ui
