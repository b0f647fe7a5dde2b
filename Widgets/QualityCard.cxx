#include "Widgets/QualityCard.h"

#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/Words.h"

#include <QGridLayout>
#include <QLabel>
#include <QLocale>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>

namespace innergs::ui {
namespace {

constexpr double kSameQuality = 0.1;     // dB that nobody sees
constexpr double kSameStructure = 0.005; // SSIM

bool isOurs(const QualityRow& row) {
  return isOurMethod(row.method);
}

QString decibel(double psnr) {
  return std::isfinite(psnr) ? QLocale().toString(psnr, 'f', 2) : QString::fromUtf8("–");
}

/// Where SSIM tells another story than PSNR.
QString structureText(const QVector<QualityRow>& rows, const QualityRow& ours) {
  const QualityRow* best = nullptr;
  for (const QualityRow& row : rows)
    if (!isOurs(row) && std::isfinite(row.ssim) && (!best || row.ssim > best->ssim)) best = &row;
  if (!best || !(best->ssim - ours.ssim >= kSameStructure)) return {};
  return QualityCard::tr(" By SSIM, which judges structure, %1 is better.")
      .arg(methodText(best->method).toLower());
}

/// What the scores do not speak of.
QString scopeText(const Report& report) {
  if (report.quality.isEmpty() || report.scans < 2) return {};
  return QualityCard::tr("Judged on the first scan alone, which says little about the %n scans together. ",
                         nullptr, report.scans);
}

/// How InnerGS stands against the best of the others, in words.
QString verdictText(const Report& report) {
  const QVector<QualityRow>& rows = report.quality;
  const auto ours = std::find_if(rows.begin(), rows.end(), isOurs);
  const QualityRow* best = nullptr;
  for (const QualityRow& row : rows)
    if (!isOurs(row) && std::isfinite(row.psnr) && (!best || row.psnr > best->psnr)) best = &row;
  if (ours == rows.end() || !best || !std::isfinite(ours->psnr)) return {};
  const double gain = ours->psnr - best->psnr;
  const QString by = QLocale().toString(std::abs(gain), 'f', 1), other = methodText(best->method).toLower();
  if (gain >= kSameQuality)
    return QualityCard::tr("On slices that no method saw, InnerGS is %1 dB closer to the truth than the best "
                           "of the others (%2).")
               .arg(by, other) +
           structureText(rows, *ours);
  if (gain <= -kSameQuality && report.scans > 1)
    return QualityCard::tr("On slices that no method saw, %2 is %1 dB closer to the truth than InnerGS.")
        .arg(by, other);
  if (gain <= -kSameQuality)
    return QualityCard::tr(
               "On slices that no method saw, %2 is %1 dB closer to the truth than InnerGS: try the "
               "preset \"best\", or keep to interpolation for this scan.")
        .arg(by, other);
  return QualityCard::tr("On slices that no method saw, InnerGS is as good as the best of the others (%1).")
             .arg(other) +
         structureText(rows, *ours);
}

} // namespace

QualityCard::QualityCard(QWidget* parent)
    : QWidget(parent), summary_(makeWrappedLabel("resultSummary", this)),
      verdict_(makeWrappedLabel("qualityVerdict", this)), heldOut_(makeWrappedLabel("heldOutQuality", this)),
      samples_(makeWrappedLabel("qualitySamples", this)),
      training_(makeWrappedLabel("trainingQuality", this)), warnings_(new MessageLine(this)),
      table_(new QWidget(this)), grid_(nullptr) {
  table_->setObjectName("qualityTable");
  warnings_->setObjectName("resultWarnings");
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  for (QWidget* part : {static_cast<QWidget*>(summary_), static_cast<QWidget*>(warnings_),
                        static_cast<QWidget*>(verdict_), table_, static_cast<QWidget*>(samples_),
                        static_cast<QWidget*>(heldOut_), static_cast<QWidget*>(training_)})
    layout->addWidget(part);
  hide();
}

void QualityCard::clear() {
  hide();
}

void QualityCard::setReport(const Report& report) {
  const QLocale locale;
  QStringList summary{tr("Done in %1.").arg(exactDuration(report.seconds))};
  if (report.gaussians > 0) summary << sentence(gaussiansText(report.gaussians));
  if (!report.device.isEmpty()) summary << sentence(report.device);
  summary_->setText(summary.join(' '));
  summary_->setToolTip(report.settings);

  QStringList lines;
  for (const QString& warning : report.warnings)
    lines << sentence(warning);
  warnings_->setMessage(MessageLine::Kind::Warning, lines.join('\n'));

  const auto set = [](QLabel* label, const QString& text) {
    label->setText(text);
    label->setVisible(!text.isEmpty());
  };
  set(verdict_, scopeText(report) + verdictText(report));
  setTable(report.quality);
  set(samples_,
      report.quality.isEmpty() ? QString() : tr("Scored on held-out slices. %1").arg(report.qualitySamples));
  if (std::isfinite(report.heldOutPsnr))
    set(heldOut_,
        tr("%1 dB PSNR on held-out slices, withheld from this fit.").arg(decibel(report.heldOutPsnr)));
  else
    set(heldOut_, report.quality.isEmpty()
                      ? tr("The quality between slices was not measured: tick \"Measure the quality\" before "
                           "the next start.")
                      : QString());
  set(training_, std::isfinite(report.trainingPsnr)
                     ? tr("%1 dB PSNR on the fitted samples, not held out: how closely the model follows the "
                          "scans, not how true it is between their slices.")
                           .arg(decibel(report.trainingPsnr))
                     : QString());
  show();
}

void QualityCard::setTable(const QVector<QualityRow>& rows) {
  delete grid_;
  qDeleteAll(table_->findChildren<QLabel*>());
  grid_ = new QGridLayout(table_);
  grid_->setContentsMargins(0, 0, 0, 0);
  grid_->setVerticalSpacing(2);
  double best = -INFINITY;
  for (const QualityRow& row : rows)
    best = std::max(best, row.psnr);
  const auto cell = [this](int r, int c, const QString& text, bool bold) {
    auto* label = new QLabel(text, table_);
    label->setObjectName(QString("quality-%1-%2").arg(r).arg(c));
    QFont font = label->font();
    font.setBold(bold);
    label->setFont(font);
    grid_->addWidget(label, r, c, c == 0 ? Qt::AlignLeft : Qt::AlignRight);
  };
  cell(0, 0, tr("Method"), true);
  cell(0, 1, tr("PSNR (dB)"), true);
  cell(0, 2, tr("SSIM"), true);
  for (int r = 0; r < rows.size(); ++r) {
    cell(r + 1, 0, methodText(rows[r].method), isOurs(rows[r]));
    cell(r + 1, 1, decibel(rows[r].psnr), rows[r].psnr == best);
    cell(r + 1, 2,
         std::isfinite(rows[r].ssim) ? QLocale().toString(rows[r].ssim, 'f', 3) : QString::fromUtf8("–"),
         false);
  }
  grid_->setColumnStretch(0, 1);
  grid_->setHorizontalSpacing(2 * fontMetrics().averageCharWidth());
  table_->setVisible(!rows.isEmpty());
}

} // namespace innergs::ui
