#pragma once
#include "Widgets/Host.h"

#include <QPointer>
#include <QTimer>
#include <QWidget>

class QCheckBox;
class QComboBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QSpinBox;

namespace innergs::ui {

class DeviceBox;
class InputsTable;
class MessageLine;
class NumberSpin;
class OutputBox;
class PinnedRow;
class ProgressCard;
class QualityCard;
class RecoveryLine;
class SettingsPanel;
class SlicesLine;

/// From scans to a result: what to reconstruct and how, what it will take, one button that starts and
/// cancels, progress, and what came out. Grows downwards: to be shown in a scroll area, in which the button
/// and the progress stay in view.
class ReconstructionPanel : public QWidget {
  Q_OBJECT
public:
  explicit ReconstructionPanel(Host* host, QWidget* parent = nullptr);
  ~ReconstructionPanel() override;
  Request request() const;
  /// Does not emit requestChanged.
  void setRequest(const Request& request);
  /// Chooses the scan that the program shows, unless the user has chosen another or a fit is running. Emits
  /// requestChanged.
  void suggestInput(const QString& id);
  /// Hides a finished run, whose result is gone. A running one continues.
  void forgetResult();

public Q_SLOTS:
  /// What the button does.
  void startOrCancel();

Q_SIGNALS:
  /// By the user, or because a chosen volume was removed from the host.
  void requestChanged();

protected:
  void showEvent(QShowEvent* event) override;

private:
  enum class State { Idle, Running, Cancelling };

  QWidget* makeInputs();
  QWidget* makeOutput();
  QWidget* makeFit();
  QWidget* makeAdvanced();
  QWidget* makeQualityOptions();
  QWidget* makeStart();
  void connectHost();
  /// Labels the mask by the number of scans, and enables the value outside if there is a mask.
  void explainMask();
  void edited();
  void explain();
  /// Why it cannot start, as far as that is known without asking the host; "": no reason is known.
  QString ownRefusal(const Request& request) const;
  void estimate();
  void setState(State state);

  Host* host_;
  State state_ = State::Idle;
  QTimer estimateTimer_{this}, memoryTimer_;
  bool quiet_ = false;
  QString refusal_;
  double heldOutFraction_ = 0; // what was set stays as it was until it is edited
  int qualityGap_ = 0;
  bool focusMoved_ = false; // off the button, because it was disabled
  QPointer<QWidget> movedTo_;

  QWidget* choices_; // everything that is greyed while it runs
  InputsTable* inputs_;
  Selector *mask_ = nullptr, *region_ = nullptr;
  QLabel* maskLabel_ = nullptr;
  NumberSpin* fill_ = nullptr;
  OutputBox* output_;
  QComboBox* preset_;
  QLabel* presetLine_;
  DeviceBox* device_;
  QCheckBox *evaluate_, *uncertainty_;
  QSpinBox* gap_;
  QDoubleSpinBox* heldOut_;
  SettingsPanel* settings_;
  QLabel* estimate_;
  MessageLine *refusalLine_, *message_;
  QPushButton* button_;
  PinnedRow* start_; // the button and the message beside it
  RecoveryLine* recovery_;
  ProgressCard* progress_;
  QualityCard* quality_;
  SlicesLine* slices_;
};

} // namespace innergs::ui
