#pragma once
#include "Core/Job/Progress.h"

#include <QElapsedTimer>
#include <QTimer>
#include <QWidget>

class QLabel;
class QProgressBar;
class vtkImageData;
class vtkMatrix4x4;

namespace innergs::ui {

class FitChart;
class PreviewView;

/// A running reconstruction: the chart of the fit, a preview, and a head with phase, percent and remaining
/// time. While the quality is judged by a second fit, chart and figures stay those of the first.
class ProgressCard : public QWidget {
  Q_OBJECT
public:
  explicit ProgressCard(QWidget* parent = nullptr);
  /// Visible while it runs; who shows the card may place it elsewhere.
  QWidget* head() const { return head_; }
  /// Before the first report.
  void begin();
  /// Shown at once when the phase changes, else a few times a second.
  void setProgress(const Progress& progress);
  /// Whether it is the first one.
  bool setPreview(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  /// For another reconstruction, until the first report.
  void setWaiting();
  void setCancelling();
  /// What is worth keeping after the end: the chart.
  void finish();

protected:
  void changeEvent(QEvent* event) override;

private:
  void showLatest();
  void showNumbers();
  void showRemaining(double seconds);

  QWidget* head_;
  QLabel *phase_, *remaining_, *numbers_, *note_, *chartNote_;
  QProgressBar* bar_;
  FitChart* chart_;
  PreviewView* preview_;
  Progress latest_, shown_, fit_; // fit_: the last iteration of the fit, the end of the chart's line
  bool fresh_ = false;            // latest_ is not shown yet
  QTimer timer_;
  QElapsedTimer sinceRemaining_;
  bool cancelling_ = false;
};

} // namespace innergs::ui
