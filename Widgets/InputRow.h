#pragma once
#include "Widgets/Host.h"

#include <QWidget>

class QComboBox;
class QLabel;
class QToolButton;

namespace innergs::ui {

class NumberSpin;

/// One scan: which volume, the orientation of its slices, their thickness (mm), profile and axis, and, among
/// several, a mask of its own; where there are transforms of slices, those of its own.
class InputRow : public QWidget {
  Q_OBJECT
public:
  InputRow(Host* host, QWidget* parent);
  /// Without an ID while nothing is selected.
  InputChoice choice() const;
  void setChoice(const InputChoice& choice);
  /// The row's number, from 1, for names and mnemonics; whether it is the only one.
  void setPlace(int number, bool alone);
  /// Shows the volume again after a change in the host.
  void refresh();
  /// In the order of Tab.
  QVector<QWidget*> fields() const;

Q_SIGNALS:
  void changed();
  void removeRequested();

protected:
  void changeEvent(QEvent* event) override;

private:
  void showOptional();

  Host* host_;
  Selector *selector_, *mask_ = nullptr, *poses_ = nullptr; // the latter null where the host has none
  QLabel *title_, *description_;
  QWidget *maskRow_, *posesRow_;
  bool alone_ = true;
  NumberSpin* thickness_;
  QComboBox *profile_, *axis_;
  QToolButton* remove_;
  InputChoice choice_; // except the IDs; values stay exact until they are edited
};

} // namespace innergs::ui
