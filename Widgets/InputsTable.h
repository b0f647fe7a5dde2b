#pragma once
#include "Widgets/Host.h"

#include <QWidget>

class QToolButton;
class QVBoxLayout;

namespace innergs::ui {

class InputRow;

/// The scans of a reconstruction. At least one row, which may be empty.
class InputsTable : public QWidget {
  Q_OBJECT
public:
  explicit InputsTable(Host* host, QWidget* parent = nullptr);
  /// Skips rows without a choice.
  QVector<InputChoice> inputs() const;
  void setInputs(const QVector<InputChoice>& inputs);
  /// Selects a scan in the only row, unless the user selected another one or changed how it is read.
  void suggest(const QString& id);

Q_SIGNALS:
  void changed();
  /// The same choice, but the host's volumes have changed.
  void refreshed();

private:
  InputRow* addRow();
  void removeRow(InputRow* row);
  void number();
  void chainTabs();
  void tell();

  Host* host_;
  QVBoxLayout* rowsLayout_;
  QVector<InputRow*> rows_;
  QToolButton* add_;
  QVector<InputChoice> lastInputs_;
  QString suggested_;
};

} // namespace innergs::ui
