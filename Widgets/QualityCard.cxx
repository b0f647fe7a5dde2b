#include "Widgets/QualityCard.h"

#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/QualityVerdict.h"
#include "Widgets/TextFormat.h"

#include <QGridLayout>
#include <QLabel>
#include <QLocale>
#include <QVBoxLayout>

#include <algorithm>
#include <cmath>

namespace innergs::ui {
namespace {

QString decibel(double psnr) {
  return std::isfinite(psnr) ? QLocale().toString(psnr, 'f', 2) : QString::fromUtf8("–");
}

/// Limits of the scores.
QString scopeText(const Report& report) {
  if (report.quality.isEmpty() || report.scans < 2) return {};
  return QualityCard::tr("Judged on the first scan alone, which says little about the %n scans together. ",
                         nullptr, report.scans);
}

QString psnrText(const Measured& psnr) {
  const QString other = methodText(psnr.other).toLower();
  const QString by = QLocale().toString(std::abs(psnr.gain), 'f', 1);
  return psnr.sign > 0   ? QualityCard::tr("%1 dB more PSNR than %2").arg(by, other)
         : psnr.sign < 0 ? QualityCard::tr("%1 dB less PSNR than %2").arg(by, other)
                         : QualityCard::tr("the same PSNR as %1").arg(other);
}

QString ssimText(const Measured& ssim) {
  const QString other = methodText(ssim.other).toLower();
  const QString by = QLocale().toString(std::abs(ssim.gain), 'f', 3);
  return ssim.sign > 0   ? QualityCard::tr("%1 more SSIM than %2").arg(by, other)
         : ssim.sign < 0 ? QualityCard::tr("%1 less SSIM than %2").arg(by, other)
                         : QualityCard::tr("the same SSIM as %1").arg(other);
}

/// How InnerGS compares with the best of the others.
QString verdictText(const Report& report) {
  const Comparison found = compare(report.quality);
  QStringList measures;
  if (!std::isnan(found.psnr.gain)) measures << psnrText(found.psnr);
  if (!std::isnan(found.ssim.gain)) measures << ssimText(found.ssim);
  const QString by = measures.join(QualityCard::tr(", "));
  switch (found.verdict) {
  case Verdict::Unknown:
    break;
  case Verdict::Better:
    return QualityCard::tr("On held-out slices, InnerGS is better than the others: %1.").arg(by);
  case Verdict::AsGood:
    return QualityCard::tr("On held-out slices, InnerGS is as good as the best of the others: %1.").arg(by);
  case Verdict::Mixed:
    return QualityCard::tr("On held-out slices, InnerGS is better by one measure and worse by the "
                           "other: %1.")
        .arg(by);
  case Verdict::Worse: {
    const QString text =
        QualityCard::tr("On held-out slices, InnerGS is worse than the best of the others: %1.").arg(by);
    return report.scans > 1 ? text
                            : text + QualityCard::tr(" Try the preset 'best', or use interpolation for "
                                                     "this scan.");
  }
  }
  return {};
}

} // namespace

QualityCard::QualityCard(QWidget* parent)
    : QWidget(parent), summary_(makeWrappedLabel("resultSummary", this)),
      profile_(makeWrappedLabel("resultProfile", this)),
      agreement_(makeWrappedLabel("resultAgreement", this)),
      prediction_(makeWrappedLabel("resultPrediction", this)),
      uncertainty_(makeWrappedLabel("resultUncertainty", this)),
      verdict_(makeWrappedLabel("qualityVerdict", this)), heldOut_(makeWrappedLabel("heldOutQuality", this)),
      samples_(makeWrappedLabel("qualitySamples", this)),
      training_(makeWrappedLabel("trainingQuality", this)), warnings_(new MessageLine(this)),
      table_(new QWidget(this)), grid_(nullptr) {
  table_->setObjectName("qualityTable");
  warnings_->setObjectName("resultWarnings");
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  for (QWidget* part : QWidgetList{summary_, agreement_, profile_, prediction_, uncertainty_, warnings_,
                                   verdict_, table_, samples_, heldOut_, training_})
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
  set(profile_, report.profile);
  set(agreement_, report.agreement);
  set(prediction_, report.prediction);
  set(uncertainty_, report.uncertainty.isEmpty() ? QString() : tr("Uncertainty: %1").arg(report.uncertainty));
  set(verdict_, scopeText(report) + verdictText(report));
  setTable(report.quality);
  set(samples_,
      report.quality.isEmpty() ? QString() : tr("Scored on held-out slices. %1").arg(report.qualitySamples));
  if (std::isfinite(report.heldOutPsnr))
    set(heldOut_, tr("%1 dB PSNR on %n held-out slices, from a second fit that did not see them.", nullptr,
                     report.heldOutSlices)
                      .arg(decibel(report.heldOutPsnr)));
  else // if it was asked for and failed, the warnings say why
    set(heldOut_, report.quality.isEmpty() && report.judging == Judging::NotAsked
                      ? tr("The quality between slices was not judged: tick 'Judge the quality' before "
                           "the next start.")
                      : QString());
  set(training_,
      std::isfinite(report.trainingPsnr)
          ? tr("%1 dB PSNR on the fitted samples, not held out, of the finished model: how closely "
               "it follows the scans, not how true it is between their slices.")
                .arg(decibel(report.trainingPsnr))
      : std::isinf(report.trainingPsnr) ? tr("The finished model reproduces the scans in their slices; this "
                                             "does not say how accurate it is between them.")
                                        : QString());
  show();
}

void QualityCard::setTable(const QVector<QualityRow>& rows) {
  delete grid_;
  qDeleteAll(table_->findChildren<QLabel*>());
  grid_ = new QGridLayout(table_);
  grid_->setContentsMargins(0, 0, 0, 0);
  grid_->setVerticalSpacing(2);
  double bestPsnr = -INFINITY, bestSsim = -INFINITY;
  for (const QualityRow& row : rows) {
    bestPsnr = std::max(bestPsnr, row.psnr);
    bestSsim = std::max(bestSsim, row.ssim);
  }
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
    cell(r + 1, 0, methodText(rows[r].method), rows[r].isOurs());
    cell(r + 1, 1, decibel(rows[r].psnr), rows[r].psnr == bestPsnr);
    cell(r + 1, 2,
         std::isfinite(rows[r].ssim) ? QLocale().toString(rows[r].ssim, 'f', 3) : QString::fromUtf8("–"),
         rows[r].ssim == bestSsim);
  }
  grid_->setColumnStretch(0, 1);
  grid_->setHorizontalSpacing(2 * fontMetrics().averageCharWidth());
  table_->setVisible(!rows.isEmpty());
}

} // namespace innergs::ui
