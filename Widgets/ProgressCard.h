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

/// A running reconstruction: the chart of the fit, a preview, and a head with phase, percentage and remaining
/// time. While a second fit judges the quality, chart and figures stay those of the first.
class ProgressCard : public QWidget {
  Q_OBJECT
public:
  explicit ProgressCard(QWidget* parent = nullptr);
  /// Visible while it runs; the owner of the card may place it elsewhere.
  QWidget* head() const { return head_; }
  /// Call before the first report.
  void begin();
  /// Shown at once if the phase changes, else a few times per second.
  void setProgress(const Progress& progress);
  /// Returns whether it is the first one.
  bool setPreview(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  /// Waits for another reconstruction, until the first report.
  void setWaiting();
  void setCancelling();
  /// Keeps only the chart.
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
  Progress latest_, shown_, fit_; // fit_: the last iteration of the fit, where the chart's line ends
  bool fresh_ = false;            // latest_ has not been shown yet
  QTimer timer_;
  QElapsedTimer sinceRemaining_;
  bool cancelling_ = false;
};

} // namespace innergs::ui
