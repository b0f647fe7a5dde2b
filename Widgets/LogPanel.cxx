#include "Widgets/LogPanel.h"

#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include <QClipboard>
#include <QFontDatabase>
#include <QGuiApplication>
#include <QHBoxLayout>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QTime>
#include <QVBoxLayout>

#include <cmath>

namespace innergs::ui {
namespace {

constexpr int kMostLines = 5000;

} // namespace

LogPanel::LogPanel(Host* host, QWidget* parent) : QWidget(parent), edit_(new QPlainTextEdit(this)) {
  named(edit_, "logText", tr("What has happened so far, with the time of day."));
  edit_->setReadOnly(true);
  edit_->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  edit_->setTabChangesFocus(true);
  edit_->setMaximumBlockCount(kMostLines);
  edit_->setMinimumHeight(6 * fontMetrics().lineSpacing());
  edit_->setAccessibleName(tr("Log"));
  auto* copyButton =
      named(new QPushButton(tr("Cop&y"), this), "copyLog", tr("Copy the whole log to the clipboard."));
  auto* clearButton = named(new QPushButton(tr("C&lear"), this), "clearLog", tr("Empty the log."));
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(copyButton);
  buttons->addWidget(clearButton);
  buttons->addStretch(1);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addWidget(edit_, 1);
  layout->addLayout(buttons);
  connect(copyButton, &QPushButton::clicked, this, &LogPanel::copy);
  connect(clearButton, &QPushButton::clicked, edit_, &QPlainTextEdit::clear);

  connect(host, &Host::logged, this, &LogPanel::add);
  connect(host, &Host::started, this, [this] { add(tr("Reconstruction started.")); });
  connect(host, &Host::progressed, this, [this](const Progress& progress) {
    if (!progress.note.empty()) add(QString::fromStdString(progress.note));
  });
  connect(host, &Host::failed, this, [this](const QString& text) { add(tr("Error: %1").arg(text)); });
  connect(host, &Host::cancelled, this, [this] { add(tr("Cancelled.")); });
  connect(host, &Host::ended, this, &LogPanel::add);
  connect(host, &Host::finished, this, &LogPanel::addReport);
}

QString LogPanel::text() const {
  return edit_->toPlainText();
}

void LogPanel::add(const QString& line) {
  edit_->appendPlainText(QTime::currentTime().toString("HH:mm:ss ") + line.trimmed());
}

void LogPanel::copy() {
  QGuiApplication::clipboard()->setText(text() + '\n');
}

void LogPanel::addReport(const Report& report) {
  add(tr("Done in %1: %2 %3")
          .arg(exactDuration(report.seconds), sentence(gaussiansText(report.gaussians)),
               sentence(report.device)));
  for (const QString& warning : report.warnings)
    add(tr("Warning: %1").arg(sentence(warning)));
  if (!report.profile.isEmpty()) add(report.profile);
  if (!report.agreement.isEmpty()) add(report.agreement);
  if (!report.prediction.isEmpty()) add(report.prediction);
  if (!report.uncertainty.isEmpty()) add(tr("Uncertainty: %1").arg(report.uncertainty));
  if (std::isfinite(report.trainingPsnr))
    add(tr("%1 dB on the fitted samples, not held out.").arg(report.trainingPsnr, 0, 'f', 2));
  if (std::isfinite(report.heldOutPsnr))
    add(tr("%1 dB on %n held-out slices, from a second fit that did not see them.", nullptr,
           report.heldOutSlices)
            .arg(report.heldOutPsnr, 0, 'f', 2));
  for (const QualityRow& row : report.quality)
    add(tr("%1: %2 dB, SSIM %3")
            .arg(methodText(row.method))
            .arg(row.psnr, 0, 'f', 2)
            .arg(row.ssim, 0, 'f', 3));
  if (!report.qualitySamples.isEmpty()) add(sentence(report.qualitySamples));
  if (!report.settings.isEmpty()) add(tr("Settings: %1").arg(report.settings));
}

} // namespace innergs::ui
