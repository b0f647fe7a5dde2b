#pragma once
#include "Core/Progress.h"

#include <QWidget>

#include <vector>

namespace innergs::ui {

/// PSNR (left axis, dB) and loss (right axis, logarithmic) over the sweeps. Drawn by Qt alone: a chart in
/// OpenGL held the window while its shaders were compiled.
class FitChart : public QWidget {
  Q_OBJECT
public:
  explicit FitChart(QWidget* parent = nullptr);
  void clear();
  /// A report of a sweep already known is left out. Shown at the next update(), which the owner calls.
  void add(const Progress& progress);
  int points() const { return static_cast<int>(points_.size()); }

protected:
  void paintEvent(QPaintEvent* event) override;

private:
  struct Point {
    double sweep, fit, heldOut, loss; // fit and heldOut: dB, or NaN
  };
  struct Scale; // from values to pixels

  void drawAxes(QPainter& painter, const Scale& sweeps, const Scale& decibels) const;
  void drawCurve(QPainter& painter, const Scale& across, const Scale& up, double Point::*value) const;

  std::vector<Point> points_;
};

} // namespace innergs::ui
