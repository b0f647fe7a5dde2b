#pragma once
#include "Widgets/Host.h"

#include <QWidget>

class QComboBox;
class QLabel;
class QToolButton;
class QVBoxLayout;

namespace innergs::ui {

class NumberSpin;

/// One scan: which, how its slices lie, their thickness (mm), profile and axis.
class InputRow : public QWidget {
  Q_OBJECT
public:
  InputRow(Host* host, QWidget* parent);
  /// Without an ID while nothing is chosen.
  InputChoice choice() const;
  void setChoice(const InputChoice& choice);
  /// The row's number, from 1, for names and mnemonics; whether it is the only one.
  void setPlace(int number, bool alone);
  /// Shows the volume again after a change in the host.
  void refresh();
  /// The Tab key comes here from the last field of another row.
  void setTabAfter(InputRow* other);
  QWidget* firstField() const;
  QWidget* lastField() const;

Q_SIGNALS:
  void changed();
  void removeRequested();

protected:
  void changeEvent(QEvent* event) override;

private:
  void chainTabs();

  Host* host_;
  Selector* selector_;
  QLabel *title_, *description_;
  NumberSpin* thickness_;
  QComboBox *profile_, *axis_;
  QToolButton* remove_;
  InputChoice choice_; // but for the ID; what was set stays as it was until it is edited
};

/// The scans of a reconstruction. At least one row, which may be without a choice.
class InputsTable : public QWidget {
  Q_OBJECT
public:
  explicit InputsTable(Host* host, QWidget* parent = nullptr);
  /// Rows without a choice are left out.
  QVector<InputChoice> inputs() const;
  void setInputs(const QVector<InputChoice>& inputs);
  /// Chooses a scan for the only row, unless the user chose another one or changed how it is read.
  void suggest(const QString& id);

Q_SIGNALS:
  void changed();
  /// The same choice, but the host's volumes changed.
  void refreshed();

private:
  InputRow* addRow();
  void removeRow(InputRow* row);
  void number();
  void tell();

  Host* host_;
  QVBoxLayout* rowsLayout_;
  QVector<InputRow*> rows_;
  QToolButton* add_;
  QVector<InputChoice> told_;
  QString suggested_;
};

} // namespace innergs::ui
