#pragma once
#include <QWidget>

class QDoubleSpinBox;
class QSlider;

namespace innergs::ui {

/// A number set by a slider or by keyboard.
class ValueSlider : public QWidget {
  Q_OBJECT
public:
  /// suffix: the unit including the separator from the number, e.g. " mm". The slider moves in steps of the
  /// last decimal.
  ValueSlider(const QString& suffix, int decimals, QWidget* parent = nullptr);

  double value() const;
  void setValue(double value); // emits no signal; extends the range if necessary
  void setRange(double lowest, double highest);
  void setSingleStep(double step);
  /// Wraps around from the highest value to the lowest.
  void setWrapping(bool wrapping);
  /// For both parts; object names NAMESlider and NAMEValue.
  void describe(const QString& name, const QString& accessibleName, const QString& toolTip);
  QDoubleSpinBox* spinBox() const { return box_; }
  QSlider* slider() const { return slider_; }

Q_SIGNALS:
  void valueEdited(double value);
  void draggingChanged(bool dragging);

private:
  void showOnSlider();

  QSlider* slider_;
  QDoubleSpinBox* box_;
  double perStep_;
};

} // namespace innergs::ui
