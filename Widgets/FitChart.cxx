#include "Widgets/FitChart.h"

#include <QLocale>
#include <QPainter>
#include <QPolygonF>

#include <algorithm>
#include <cmath>

namespace innergs::ui {
namespace {

constexpr std::size_t kMostPoints = 2000;

/// 1, 2 or 5 times a power of ten: the step of at most `most` intervals over `range`.
double tickStep(double range, int most) {
  const double raw = range / std::max(1, most), power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (raw <= factor * power * 1.000001) return factor * power;
  return 10 * power;
}

} // namespace

struct FitChart::Scale {
  double low = INFINITY, high = -INFINITY; // values
  double from = 0, to = 0;                 // pixels
  double step = 1;                         // between ticks

  void add(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  void place(double first, double last, int mostTicks) {
    if (!(low <= high)) low = 0, high = 1;
    if (high - low < 1e-9 * std::max(1.0, std::abs(high))) low -= 0.5, high += 0.5;
    from = first;
    to = last;
    step = tickStep(high - low, mostTicks);
  }
  /// Extends the range to whole ticks.
  void widen() {
    low = step * std::floor(low / step + 1e-9);
    high = step * std::ceil(high / step - 1e-9);
  }
  double operator()(double value) const { return from + (value - low) / (high - low) * (to - from); }
};

FitChart::FitChart(QWidget* parent) : QWidget(parent) {
  setMinimumHeight(9 * fontMetrics().lineSpacing());
  setAccessibleName(tr("PSNR on the fitted samples and loss over the iterations"));
  setToolTip(tr("Thick, left axis: PSNR in dB on the fitted samples (not held out), iteration by iteration.\n"
                "Thin, right axis: the loss, which has no unit, on a logarithmic scale."));
  setAttribute(Qt::WA_OpaquePaintEvent);
}

void FitChart::clear() {
  points_.clear();
  members_ = 1;
  coarse_ = 0;
  iterationsPerMember_ = 1e300;
  update();
}

void FitChart::add(const Progress& progress) {
  if (progress.phase != Phase::Fitting) return;
  members_ = std::max(1, progress.members);
  coarse_ = progress.coarseIterations;
  if (progress.iterations > 0) iterationsPerMember_ = static_cast<double>(progress.iterations) / members_;
  const auto iteration = static_cast<double>(progress.iteration);
  if (iteration <= (points_.empty() ? 0 : points_.back().iteration) || !(progress.loss > 0)) return;
  if (points_.size() >= kMostPoints) { // drops every second one
    std::size_t kept = 0;
    for (std::size_t n = 0; n < points_.size(); n += 2)
      points_[kept++] = points_[n];
    points_.resize(kept);
  }
  points_.push_back({iteration, progress.trainingPsnr > 0 ? progress.trainingPsnr : NAN, progress.loss});
}

int FitChart::lines() const {
  int count = points_.empty() ? 0 : 1;
  for (std::size_t n = 1; n < points_.size(); ++n)
    count += !sameLine(points_[n - 1], points_[n]);
  return count;
}

QString FitChart::explanation() const {
  QStringList sentences;
  if (members_ > 1)
    sentences << tr("An ensemble of %n models is fitted one after another and merged at the end; each starts "
                    "at a dotted line.",
                    nullptr, members_);
  if (coarse_ > 0)
    sentences << tr("Shaded: iterations that see the scans at half resolution; do not compare their figures "
                    "with the others.");
  return sentences.join(' ');
}

void FitChart::paintEvent(QPaintEvent*) {
  QPainter painter(this);
  painter.fillRect(rect(), palette().base());
  const QFontMetrics metrics = fontMetrics();
  const int line = metrics.lineSpacing(), gap = metrics.averageCharWidth();
  Scale iterations, decibels, losses;
  for (const Point& point : points_) {
    iterations.add(point.iteration);
    decibels.add(point.psnr);
    losses.add(std::log10(point.loss));
  }
  const double top = 0.7 * line, bottom = height() - 2.2 * line;
  decibels.place(bottom, top, std::max(1, static_cast<int>((bottom - top) / (1.6 * line))));
  decibels.widen();
  losses.place(bottom, top, 1);
  int wide = 0;
  for (double value = decibels.low; value <= decibels.high + 1e-9; value += decibels.step)
    wide = std::max(wide, metrics.horizontalAdvance(QLocale().toString(value, 'g', 4)));
  const double left = line + wide + 2 * gap, right = width() - 1.2 * line - gap;
  if (right - left < 4 * gap || bottom - top < line) return;
  const int label = metrics.horizontalAdvance(QLocale().toString(iterations.high, 'f', 0)) + 3 * gap;
  iterations.place(left, right, std::max(1, static_cast<int>((right - left) / std::max(label, 6 * gap))));
  iterations.step = std::max(1.0, iterations.step);
  drawParts(painter, iterations, top, bottom);
  drawAxes(painter, iterations, decibels);
  if (points_.size() < 2) return;
  painter.setRenderHint(QPainter::Antialiasing);
  painter.setClipRect(QRectF(left, top - 2, right - left, bottom - top + 4));
  QColor faint = palette().color(QPalette::Text);
  faint.setAlpha(160);
  const QColor main = palette().color(QPalette::Highlight);
  painter.setPen(QPen(faint, 1));
  drawLines(painter, iterations, [&](const Point& point) { return losses(std::log10(point.loss)); });
  painter.setPen(QPen(main, 2));
  drawLines(painter, iterations, [&](const Point& point) { return decibels(point.psnr); });
}

/// Marks where members begin, and which iterations use half the resolution.
void FitChart::drawParts(QPainter& painter, const Scale& iterations, double top, double bottom) const {
  if (points_.size() < 2) return;
  QColor shade = palette().color(QPalette::Text), mark = shade;
  shade.setAlpha(24);
  mark.setAlpha(160);
  const auto within = [&](double iteration) {
    return std::clamp(iterations(iteration), iterations.from, iterations.to);
  };
  for (int n = 0; n <= member(points_.back().iteration); ++n) {
    const double first = n * iterationsPerMember_ + 0.5;
    const QRectF coarse(QPointF(within(first), top), QPointF(within(first + coarse_), bottom));
    if (coarse.width() > 0) painter.fillRect(coarse, shade);
    if (n == 0 || first < iterations.low) continue;
    painter.setPen(QPen(mark, 1, Qt::DotLine));
    painter.drawLine(QPointF(within(first), top), QPointF(within(first), bottom));
  }
}

void FitChart::drawAxes(QPainter& painter, const Scale& iterations, const Scale& decibels) const {
  const int line = fontMetrics().lineSpacing(), gap = fontMetrics().averageCharWidth();
  const QColor text = palette().color(QPalette::Text);
  QColor grid = text;
  grid.setAlpha(40);
  const double top = decibels.to, bottom = decibels.from, left = iterations.from, right = iterations.to;
  const bool any = points_.size() > 1;
  const bool known = any && std::any_of(points_.begin(), points_.end(),
                                        [](const Point& point) { return std::isfinite(point.psnr); });
  const QLocale locale;
  if (known)
    for (double value = decibels.low; value <= decibels.high + 1e-9; value += decibels.step) {
      const double y = decibels(value);
      painter.setPen(grid);
      painter.drawLine(QPointF(left, y), QPointF(right, y));
      painter.setPen(text);
      painter.drawText(QRectF(line, y - line, left - line - gap, 2 * line), Qt::AlignRight | Qt::AlignVCenter,
                       locale.toString(value, 'g', 4));
    }
  if (any)
    for (double value = iterations.step * std::ceil(iterations.low / iterations.step);
         value <= iterations.high + 1e-9; value += iterations.step) {
      const double x = iterations(value), half = 10 * gap;
      painter.setPen(grid);
      painter.drawLine(QPointF(x, top), QPointF(x, bottom));
      painter.setPen(text);
      painter.drawText(QRectF(x - half, bottom, 2 * half, 1.1 * line), Qt::AlignHCenter | Qt::AlignBottom,
                       locale.toString(value, 'f', 0));
    }
  painter.setPen(text);
  painter.drawLine(QPointF(left, top), QPointF(left, bottom));
  painter.drawLine(QPointF(left, bottom), QPointF(right, bottom));
  painter.drawLine(QPointF(right, top), QPointF(right, bottom));
  painter.drawText(QRectF(left, bottom + 1.05 * line, right - left, 1.1 * line), Qt::AlignCenter,
                   tr("Iteration"));
  const auto drawSide = [&](double x, const QString& name) { // upwards
    painter.save();
    QFont font = painter.font();
    const double wide = fontMetrics().horizontalAdvance(name), most = height() - 0.6 * line;
    if (font.pointSizeF() > 0 && wide > most) font.setPointSizeF(font.pointSizeF() * most / wide);
    painter.setFont(font);
    painter.translate(x, 0.5 * height());
    painter.rotate(-90);
    painter.drawText(QRectF(-0.5 * height(), 0, height(), line), Qt::AlignCenter, name);
    painter.restore();
  };
  drawSide(0.1 * line, tr("PSNR, fitted samples (dB)"));
  drawSide(right + 0.1 * line, tr("Loss")); // its value is shown beside the chart
}

template <class Height>
void FitChart::drawLines(QPainter& painter, const Scale& across, Height height) const {
  QPolygonF line;
  for (std::size_t n = 0; n < points_.size(); ++n) {
    if (n > 0 && !sameLine(points_[n - 1], points_[n])) {
      painter.drawPolyline(line);
      line.clear();
    }
    if (const double y = height(points_[n]); std::isfinite(y))
      line << QPointF(across(points_[n].iteration), y);
  }
  painter.drawPolyline(line);
}

} // namespace innergs::ui
