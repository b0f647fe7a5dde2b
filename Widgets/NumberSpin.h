#pragma once
#include <QDoubleSpinBox>

#include <optional>

namespace innergs::ui {

/// A number without padding zeros, over many orders of magnitude. If `automatic` is allowed, an empty field
/// or a step below the lowest value means that no number is given. Unedited text keeps the number with all
/// its digits.
class NumberSpin : public QDoubleSpinBox {
  Q_OBJECT
public:
  struct Range {
    double lowest, highest;
    bool integer = false;
    bool automatic = false;
    double first = 0; // where steps start from automatic; 0: the lowest
  };

  /// Limits what is typed or stepped to; a larger existing value stays.
  void setHighest(double highest);
  explicit NumberSpin(const Range& range, QWidget* parent = nullptr);
  /// Nothing if automatic.
  std::optional<double> number() const;
  void setNumber(std::optional<double> number);

  QString textFromValue(double value) const override;
  double valueFromText(const QString& text) const override;
  QValidator::State validate(QString& text, int& position) const override;
  void fixup(QString& text) const override;
  void stepBy(int steps) override;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override { return sizeHint(); }

private:
  /// Without the suffix.
  QString bare(QString text) const;
  Range range_;
};

} // namespace innergs::ui
