#pragma once
#include <QWidget>

class QDoubleSpinBox;
class QSlider;

namespace innergs::ui {

/// A number by slider and by keyboard.
class ValueSlider : public QWidget {
  Q_OBJECT
public:
  /// suffix: the unit with what separates it from the number, e.g. " mm". The slider moves in steps of the
  /// last decimal.
  ValueSlider(const QString& suffix, int decimals, QWidget* parent = nullptr);

  double value() const;
  void setValue(double value); // tells nobody; widens the range where needed
  void setRange(double lowest, double highest);
  void setSingleStep(double step);
  /// From the highest value on to the lowest.
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
