#include "Widgets/RecoveryLine.h"

#include "IO/FilePath.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"

#include <QDir>
#include <QFile>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QPushButton>
#include <QVBoxLayout>

#include <algorithm>

namespace innergs::ui {
namespace {

QString textOf(const std::filesystem::path& path) {
  return QString::fromStdU16String(path.u16string());
}

} // namespace

RecoveryLine::RecoveryLine(Host* host, Scans scans, QWidget* parent)
    : QWidget(parent), host_(host), dynamic_(scans == Scans::Dynamic), message_(new MessageLine(this)),
      accept_(new QPushButton(tr("Continue"), this)), dismiss_(new QPushButton(this)) {
  message_->setObjectName(dynamic_ ? "motionRecovery" : "recovery");
  named(accept_, dynamic_ ? "motionGoOn" : "goOn",
        tr("Restore the settings of that fit; the next reconstruction of its scans continues it."));
  dismiss_->setObjectName(dynamic_ ? "motionDropRecovered" : "dropRecovered");
  auto* buttons = new QHBoxLayout;
  buttons->addStretch(1);
  buttons->addWidget(accept_);
  buttons->addWidget(dismiss_);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addWidget(message_);
  layout->addLayout(buttons);
  connect(accept_, &QPushButton::clicked, this, &RecoveryLine::accept);
  connect(dismiss_, &QPushButton::clicked, this, &RecoveryLine::dismiss);
  refresh();
}

void RecoveryLine::setFile(const QString& file) {
  if (file == file_) return;
  file_ = file;
  refresh();
}

bool RecoveryLine::refresh() {
  const QString folder = host_->recoveryFolder();
  std::vector<RecoveredFit> fits =
      folder.isEmpty() ? std::vector<RecoveredFit>() : recoveredFits(pathOf(folder.toStdString()));
  std::erase_if(fits, [this](const RecoveredFit& fit) { return fit.dynamic != dynamic_; });
  const std::filesystem::path before = offered_.file;
  offered_ = fits.empty() ? RecoveredFit() : fits.front();
  if (!file_.isEmpty()) {
    const auto found = std::find_if(fits.begin(), fits.end(), [this](const RecoveredFit& fit) {
      return QFileInfo(textOf(fit.file)) == QFileInfo(file_);
    });
    const QString what =
        found == fits.end() ? QFileInfo(file_).fileName() : QString::fromStdString(found->inputs);
    message_->say(
        (dynamic_ ? tr("The next reconstruction continues that of '%1': choose the same scan and settings.")
                  : tr("The next reconstruction continues that of '%1': choose the same scans, mask and "
                       "settings."))
            .arg(what));
  } else if (!offered_.file.empty()) {
    const QString scans = QString::fromStdString(offered_.inputs);
    const QString stopped =
        offered_.iteration < offered_.iterations
            ? tr("The reconstruction of '%1' was stopped at iteration %2 of %3.")
                  .arg(scans)
                  .arg(offered_.iteration)
                  .arg(offered_.iterations)
            : tr("The reconstruction of '%1' was stopped when its fit was complete.").arg(scans);
    message_->say(stopped + ' ' +
                  tr("Its state is kept in %1.").arg(QDir::toNativeSeparators(textOf(offered_.file))));
  }
  accept_->setVisible(file_.isEmpty());
  dismiss_->setText(file_.isEmpty() ? tr("Delete") : tr("Start Over"));
  dismiss_->setToolTip(file_.isEmpty() ? tr("Delete the file: that fit can no longer be continued.")
                                       : tr("The next reconstruction starts from the scans alone."));
  setVisible(!file_.isEmpty() || !offered_.file.empty());
  return !offered_.file.empty() && offered_.file != before;
}

void RecoveryLine::accept() {
  const RecoveredFit fit = offered_;
  setFile(textOf(fit.file));
  Q_EMIT chosen(fit);
}

void RecoveryLine::dismiss() {
  if (file_.isEmpty()) {
    QFile::remove(textOf(offered_.file));
    refresh();
    return;
  }
  setFile({});
  Q_EMIT dropped();
}

} // namespace innergs::ui
