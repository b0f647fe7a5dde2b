#pragma once
#include "IO/RecoveredFit.h"
#include "Widgets/Host.h"
#include "Widgets/MotionHost.h"

#include <QElapsedTimer>
#include <QTimer>

class QCheckBox;
class QComboBox;
class QLabel;
class QLineEdit;
class QProgressBar;
class QPushButton;
class QToolButton;

namespace innergs::ui {

class DeviceBox;
class MessageLine;
class NumberSpin;
class RecoveryLine;
class SettingsPanel;
class ValueSlider;

/// Dynamic scans: reconstructs one into a continuous volume in space and time, and shows such a model at any
/// time, by a slider or playing.
class MotionPanel : public QWidget {
  Q_OBJECT
public:
  /// host->motion() must not be null.
  explicit MotionPanel(Host* host, QWidget* parent = nullptr);

  void setSeriesId(const QString& id);
  QString modelId() const;
  void setModelId(const QString& id);

Q_SIGNALS:
  /// Another model of a dynamic scan was chosen or made.
  void modelIdChanged(const QString& id);

protected:
  void showEvent(QShowEvent* event) override;

private:
  void build();
  QWidget* buildFit();
  QWidget* buildView();
  void connectAll();
  MotionRequest request() const;
  void showSeries();
  void showModel();
  void showProgress(const Progress& progress);
  void showReport(const MotionReport& report);
  void ended();
  void startOrCancel();
  void chooseSliceTimes();
  void goOn(const RecoveredFit& fit);
  void play(bool on);
  void advance();
  void showAt(double seconds);
  void saveFrames();
  void saveModel();
  /// error: why it was not; "": it was.
  void saySaved(const QString& file, const QString& error);

  Host* host_;
  MotionHost* motion_;
  MotionInfo info_; // of the model
  QString modelId_; // as modelIdChanged() last gave it
  bool cancelling_ = false;
  bool previewing_ = false; // info_ is of the model that is being fitted
  double playedFrom_ = 0;   // s
  QElapsedTimer playing_;
  QTimer frames_{this};

  Selector *series_ = nullptr, *model_ = nullptr;
  QLabel *about_ = nullptr, *phase_ = nullptr, *quality_ = nullptr, *aboutModel_ = nullptr;
  NumberSpin *interval_ = nullptr, *rate_ = nullptr;
  QComboBox *kind_ = nullptr, *speed_ = nullptr;
  QCheckBox* judge_ = nullptr;
  DeviceBox* device_ = nullptr;
  QLineEdit* sliceTimes_ = nullptr;
  QPushButton *run_ = nullptr, *saveFrames_ = nullptr, *saveModel_ = nullptr;
  QProgressBar* bar_ = nullptr;
  QWidget *options_ = nullptr, *view_ = nullptr;
  QToolButton* play_ = nullptr;
  ValueSlider* time_ = nullptr;
  MessageLine* message_ = nullptr;
  RecoveryLine* recovery_ = nullptr;
  SettingsPanel* settings_ = nullptr;
};

} // namespace innergs::ui
