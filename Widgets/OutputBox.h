#pragma once
#include "Widgets/Host.h"

#include <QWidget>

class QComboBox;
class QLabel;

namespace innergs::ui {

class NumberSpin;

/// The output of a reconstruction: its grid, and the volume and model to write to.
class OutputBox : public QWidget {
  Q_OBJECT
public:
  explicit OutputBox(Host* host, QWidget* parent = nullptr);
  /// Sets grid, spacing and IDs of the outputs.
  void fill(Request& request) const;
  void set(const Request& request);
  /// Explains in the line below the grid what the choice means for these scans.
  void explain(const QVector<InputChoice>& inputs);

Q_SIGNALS:
  void changed();

private:
  void showFields();

  Host* host_;
  QComboBox* grid_;
  QLabel* explanation_;
  NumberSpin* spacing_;
  double asked_ = 1; // mm; the value set, kept exact until it is edited
  QWidget *spacingRow_, *referenceRow_;
  Selector *reference_ = nullptr, *volume_ = nullptr, *model_ = nullptr;
};

} // namespace innergs::ui
