#include "Widgets/ProgressCard.h"

#include "Widgets/FitChart.h"
#include "Widgets/PanelTools.h"
#include "Widgets/PreviewView.h"
#include "Widgets/TextFormat.h"

#include <QEvent>
#include <QGridLayout>
#include <QLabel>
#include <QLocale>
#include <QProgressBar>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs::ui {
namespace {

constexpr int kRemainingInterval = 1000; // ms between changes of the remaining time
constexpr int kShowInterval = 200;       // ms between changes of the figures
constexpr int kBarSteps = 1000;

QString stepText(const Progress& progress) {
  const bool iterates = progress.phase == Phase::Fitting || progress.phase == Phase::Judging;
  if (!iterates || progress.iterations <= 0) return phaseText(progress.phase);
  return ProgressCard::tr("%1: iteration %2 of %3", "Fitting: iteration 1 of 200")
      .arg(phaseText(progress.phase))
      .arg(progress.iteration)
      .arg(progress.iterations);
}

/// The figures of an iteration, with samples of the chart's lines.
QString numbersText(const Progress& progress, const QPalette& palette) {
  const QString main = palette.color(QPalette::Highlight).name();
  const auto entry = [](const QString& sign, const QString& colour, const QString& text) {
    return QString("<span style='white-space:nowrap'><b><font color='%1'>%2</font></b> %3</span>")
        .arg(colour, sign, text.toHtmlEscaped());
  };
  const QLocale locale;
  QStringList parts;
  if (progress.trainingPsnr > 0)
    parts << entry(QString::fromUtf8("━"), main,
                   ProgressCard::tr("%1 dB on the fitted samples, not held out")
                       .arg(locale.toString(progress.trainingPsnr, 'f', 1)));
  if (progress.loss > 0)
    parts << entry(QString::fromUtf8("─"), palette.color(QPalette::Text).name(),
                   ProgressCard::tr("loss %1").arg(locale.toString(progress.loss, 'g', 2)));
  if (progress.gaussians > 0) parts << gaussiansText(progress.gaussians).toHtmlEscaped();
  if (!parts.isEmpty()) parts << ProgressCard::tr("after iteration %1").arg(progress.iteration);
  return parts.join(QString::fromUtf8(" &nbsp; "));
}

} // namespace

ProgressCard::ProgressCard(QWidget* parent)
    : QWidget(parent), head_(new QWidget(this)), phase_(makeWrappedLabel("phaseText", head_)),
      remaining_(new QLabel(head_)), numbers_(makeWrappedLabel("fitNumbers", this)),
      note_(makeWrappedLabel("fitNote", this)), chartNote_(makeWrappedLabel("chartNote", this)),
      bar_(new QProgressBar(head_)), chart_(new FitChart(this)), preview_(new PreviewView(this)) {
  named(remaining_, "remainingText", tr("Estimated time until everything is done."));
  numbers_->setTextFormat(Qt::RichText);
  named(bar_, "progressBar", tr("Share of all the work done (%), the second fit included."));
  bar_->setRange(0, kBarSteps);
  bar_->setFormat(tr("%p %"));
  numbers_->setToolTip(tr("PSNR in dB: more is better. The loss has no unit: less is better."));
  chart_->setObjectName("fitChart");
  preview_->setObjectName("preview");
  auto* head = layoutWithoutMargins<QGridLayout>(head_);
  head->addWidget(phase_, 0, 0);
  head->addWidget(remaining_, 0, 1);
  head->addWidget(bar_, 1, 0, 1, 2);
  head->setColumnStretch(0, 1);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addWidget(head_);
  layout->addWidget(note_);
  layout->addWidget(preview_);
  layout->addWidget(numbers_);
  layout->addWidget(chart_);
  layout->addWidget(chartNote_);
  hide();
  timer_.setSingleShot(true);
  timer_.setInterval(kShowInterval);
  connect(&timer_, &QTimer::timeout, this, &ProgressCard::showLatest);
}

void ProgressCard::begin() {
  cancelling_ = fresh_ = false;
  shown_ = {};
  timer_.stop();
  phase_->setText(tr("Starting"));
  remaining_->clear();
  numbers_->clear();
  note_->clear();
  fit_ = {};
  bar_->setRange(0, kBarSteps);
  bar_->setValue(0);
  chart_->clear();
  preview_->clear();
  for (QWidget* part : QWidgetList{head_, chart_})
    part->show();
  for (QWidget* part : QWidgetList{note_, preview_, numbers_, chartNote_})
    part->hide();
  show();
}

void ProgressCard::setProgress(const Progress& progress) {
  chart_->add(progress);
  if (!progress.note.empty()) {
    note_->setText(QString::fromStdString(progress.note));
    note_->show();
  }
  latest_ = progress;
  if (progress.phase == Phase::Fitting) fit_ = progress;
  fresh_ = true;
  if (!timer_.isActive() || progress.phase != shown_.phase) showLatest();
}

void ProgressCard::showLatest() {
  if (!std::exchange(fresh_, false)) return;
  if (latest_.phase != shown_.phase) sinceRemaining_.invalidate(); // at once
  shown_ = latest_;
  timer_.start();
  chart_->update();
  if (!cancelling_) bar_->setRange(0, kBarSteps);
  bar_->setValue(static_cast<int>(std::lround(kBarSteps * std::clamp(shown_.fraction, 0.0, 1.0))));
  showNumbers();
  if (cancelling_) return;
  phase_->setText(stepText(shown_));
  showRemaining(shown_.remaining);
}

void ProgressCard::showNumbers() {
  const QString text = numbersText(fit_, palette());
  if (text.isEmpty()) return;
  numbers_->setText(text);
  numbers_->show();
  chartNote_->setText(chart_->explanation());
  chartNote_->setVisible(!chartNote_->text().isEmpty());
}

void ProgressCard::changeEvent(QEvent* event) {
  if (event->type() == QEvent::PaletteChange && !numbers_->isHidden()) showNumbers();
  QWidget::changeEvent(event);
}

void ProgressCard::showRemaining(double seconds) {
  if (!(seconds > 0) || seconds > 1e7) return remaining_->clear();
  if (!remaining_->text().isEmpty() && sinceRemaining_.isValid() &&
      sinceRemaining_.elapsed() < kRemainingInterval)
    return;
  remaining_->setText(tr("%1 left").arg(roughDuration(seconds)));
  sinceRemaining_.start();
}

bool ProgressCard::setPreview(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  const bool before = !preview_->isEmpty();
  preview_->setImage(image, ijkToRAS);
  preview_->setVisible(!preview_->isEmpty());
  return !before && !preview_->isEmpty();
}

void ProgressCard::setWaiting() {
  phase_->setText(tr("Waiting for another reconstruction to end"));
  bar_->setRange(0, 0);
}

void ProgressCard::setCancelling() {
  cancelling_ = true;
  phase_->setText(shown_.phase == Phase::Judging
                      ? tr("Stopping; the finished model is kept without its quality…")
                  : shown_.phase == Phase::Estimating
                      ? tr("Stopping; the finished model is kept without its uncertainty…")
                      : tr("Cancelling…"));
  remaining_->clear();
  bar_->setRange(0, 0);
}

void ProgressCard::finish() {
  showLatest();
  for (QWidget* part : QWidgetList{head_, preview_, note_})
    part->hide();
  preview_->clear();
  setVisible(chart_->points() > 1);
}

} // namespace innergs::ui
