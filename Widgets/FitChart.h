#pragma once
#include "Core/Progress.h"

#include <QTimer>
#include <QWidget>

#include <vtkNew.h>
#include <vtkSmartPointer.h>

class QVTKOpenGLNativeWidget;
class vtkChartXY;
class vtkContextView;
class vtkTable;

namespace innergs::ui {

/// PSNR (left axis, dB) and loss (right axis, logarithmic) over the sweeps. Drawn a few times a second.
class FitChart : public QWidget {
  Q_OBJECT
public:
  explicit FitChart(QWidget* parent = nullptr);
  ~FitChart() override;
  void clear();
  /// A report of a sweep already shown is left out.
  void add(const Progress& progress);
  int points() const;

protected:
  void changeEvent(QEvent* event) override;
  void showEvent(QShowEvent* event) override;

private:
  void make();
  void colour();
  void draw();

  QTimer timer_;
  QVTKOpenGLNativeWidget* view_;
  vtkNew<vtkTable> table_;
  vtkSmartPointer<vtkContextView> context_; // made when first shown
  vtkSmartPointer<vtkChartXY> chart_;
  int lastIteration_ = 0;
};

} // namespace innergs::ui
