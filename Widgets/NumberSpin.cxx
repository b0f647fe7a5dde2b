#include "Widgets/NumberSpin.h"

#include <QLineEdit>
#include <QLocale>
#include <QStyle>
#include <QStyleOptionSpinBox>

#include <algorithm>
#include <cmath>

namespace innergs::ui {
namespace {

/// The value below the range that means automatic.
double automaticValue(const NumberSpin::Range& range) {
  return range.lowest - 1;
}

} // namespace

NumberSpin::NumberSpin(const Range& range, QWidget* parent) : QDoubleSpinBox(parent), range_(range) {
  setDecimals(range.integer ? 0 : 12);
  setRange(range.automatic ? automaticValue(range) : range.lowest, range.highest);
  if (range.automatic) {
    setSpecialValueText(tr("automatic"));
    setValue(minimum());
  }
  setStepType(AdaptiveDecimalStepType);
  setKeyboardTracking(false);
  setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
}

void NumberSpin::setHighest(double highest) {
  range_.highest = highest;
  setMaximum(std::max(highest, value()));
}

std::optional<double> NumberSpin::number() const {
  if (range_.automatic && value() == minimum()) return std::nullopt;
  return value();
}

void NumberSpin::setNumber(std::optional<double> number) {
  setValue(number ? *number : minimum());
}

QString NumberSpin::textFromValue(double value) const {
  QLocale plain = locale();
  plain.setNumberOptions(QLocale::OmitGroupSeparator);
  return range_.integer ? plain.toString(static_cast<qlonglong>(std::llround(value)))
                        : plain.toString(value, 'g', 6);
}

double NumberSpin::valueFromText(const QString& text) const {
  if (text == specialValueText()) return minimum();
  const QString number = bare(text);
  return number == textFromValue(value()) ? value() : locale().toDouble(number);
}

QString NumberSpin::bare(QString text) const {
  if (!suffix().isEmpty() && text.endsWith(suffix())) text.chop(suffix().size());
  return text.trimmed();
}

QValidator::State NumberSpin::validate(QString& whole, int&) const {
  const QString text = whole == specialValueText() ? whole : bare(whole);
  const bool special = !specialValueText().isEmpty();
  if (special && (text == specialValueText() || text == textFromValue(minimum())))
    return QValidator::Acceptable;
  bool ok = false;
  const double value = locale().toDouble(text, &ok);
  if (ok && value >= range_.lowest && value <= range_.highest &&
      (!range_.integer || value == std::floor(value)))
    return QValidator::Acceptable;
  const bool mayBecomeOne = std::all_of(text.begin(), text.end(), [](QChar c) {
    return c.isDigit() || c == '-' || c == '+' || c == 'e' || c == 'E' || c == '.' || c == ',';
  });
  return mayBecomeOne ? QValidator::Intermediate : QValidator::Invalid;
}

void NumberSpin::fixup(QString& text) const {
  if (bare(text).isEmpty() && !specialValueText().isEmpty()) {
    text = textFromValue(minimum());
    return;
  }
  bool ok = false;
  const double value = locale().toDouble(bare(text), &ok);
  if (ok) text = textFromValue(std::clamp(value, range_.lowest, range_.highest));
}

void NumberSpin::stepBy(int steps) {
  if (range_.automatic && value() == minimum()) {
    if (steps > 0) setValue(range_.first > 0 ? range_.first : range_.lowest);
    return;
  }
  if (range_.automatic && steps < 0 && value() <= range_.lowest) return setValue(minimum());
  if (value() == 0 && !range_.integer) return setValue(steps > 0 ? 0.1 : range_.lowest); // else 1e-12
  QDoubleSpinBox::stepBy(steps);
  if (value() < range_.lowest) setValue(range_.lowest);
}

QSize NumberSpin::sizeHint() const {
  QStyleOptionSpinBox option;
  initStyleOption(&option);
  const QString number =
      (suffix().isEmpty() ? QStringLiteral("100000") : QStringLiteral("0.9375")) + suffix();
  int width = range_.automatic ? 0 : fontMetrics().horizontalAdvance(number + "  ");
  if (!specialValueText().isEmpty())
    width = std::max(width, fontMetrics().horizontalAdvance(specialValueText() + "  "));
  const QSize text(width, lineEdit()->sizeHint().height());
  return style()->sizeFromContents(QStyle::CT_SpinBox, &option, text, this);
}

} // namespace innergs::ui
