#pragma once
#include "Core/Job/Progress.h"

#include <QWidget>

#include <vector>

namespace innergs::ui {

/// PSNR on the fitted samples (left axis, dB) and loss (right axis, logarithmic) over the iterations of a
/// fit. Every member of an ensemble, and its iterations at half resolution, have separate lines. Drawn by Qt
/// only: an OpenGL chart would block the window while its shaders are compiled.
class FitChart : public QWidget {
  Q_OBJECT
public:
  explicit FitChart(QWidget* parent = nullptr);
  void clear();
  /// Adds iterations of the fit only, each once. They appear at the next update(), which the owner calls.
  void add(const Progress& progress);
  int points() const { return static_cast<int>(points_.size()); }
  /// Number of unconnected lines of one quantity.
  int lines() const;
  /// Sentences on ensembles and half resolution in the chart; "" without them.
  QString explanation() const;

protected:
  void paintEvent(QPaintEvent* event) override;

private:
  struct Point {
    double iteration, psnr, loss; // psnr: dB, or NaN
  };
  struct Scale; // from values to pixels

  void drawAxes(QPainter& painter, const Scale& iterations, const Scale& decibels) const;
  void drawParts(QPainter& painter, const Scale& iterations, double top, double bottom) const;
  template <class Height>
  void drawLines(QPainter& painter, const Scale& across, Height height) const;
  int member(double iteration) const { return static_cast<int>((iteration - 0.5) / iterationsPerMember_); }
  bool isCoarse(double iteration) const {
    return iteration - member(iteration) * iterationsPerMember_ <= coarse_;
  }
  bool sameLine(const Point& a, const Point& b) const {
    return member(a.iteration) == member(b.iteration) && isCoarse(a.iteration) == isCoarse(b.iteration);
  }

  std::vector<Point> points_;
  int members_ = 1, coarse_ = 0; // see Progress
  double iterationsPerMember_ = 1e300;
};

} // namespace innergs::ui
