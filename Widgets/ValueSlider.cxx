#include "Widgets/ValueSlider.h"

#include "Widgets/PanelTools.h"

#include <QDoubleSpinBox>
#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QSlider>

#include <algorithm>
#include <cmath>

namespace innergs::ui {

ValueSlider::ValueSlider(const QString& suffix, int decimals, QWidget* parent)
    : QWidget(parent), slider_(new QSlider(Qt::Horizontal, this)), box_(new QDoubleSpinBox(this)),
      perStep_(std::pow(10., -decimals)) {
  auto* layout = layoutWithoutMargins<QHBoxLayout>(this);
  layout->addWidget(slider_, 1);
  layout->addWidget(box_);
  box_->setSuffix(suffix);
  box_->setDecimals(decimals);
  box_->setAlignment(Qt::AlignRight);
  box_->setKeyboardTracking(false);
  box_->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("-9999.9 mm R")) +
                        2 * fontMetrics().height());
  connect(slider_, &QSlider::valueChanged, this, [this](int step) {
    const QSignalBlocker block(box_);
    box_->setValue(step * perStep_);
    Q_EMIT valueEdited(value());
  });
  connect(box_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this] {
    showOnSlider();
    Q_EMIT valueEdited(value());
  });
  connect(slider_, &QSlider::sliderPressed, this, [this] { Q_EMIT draggingChanged(true); });
  connect(slider_, &QSlider::sliderReleased, this, [this] { Q_EMIT draggingChanged(false); });
}

double ValueSlider::value() const {
  return box_->value();
}

void ValueSlider::setValue(double value) {
  if (value < box_->minimum() || value > box_->maximum())
    setRange(std::min(value, box_->minimum()), std::max(value, box_->maximum()));
  const QSignalBlocker block(box_);
  box_->setValue(value);
  showOnSlider();
}

void ValueSlider::setRange(double lowest, double highest) {
  const QSignalBlocker blockBox(box_), blockSlider(slider_);
  lowest = std::floor(lowest / perStep_ + 1e-6) * perStep_;
  highest = std::ceil(highest / perStep_ - 1e-6) * perStep_;
  box_->setRange(lowest, highest);
  slider_->setRange(static_cast<int>(std::lround(lowest / perStep_)),
                    static_cast<int>(std::lround(highest / perStep_)));
  slider_->setPageStep(std::max(slider_->singleStep(), (slider_->maximum() - slider_->minimum()) / 20));
  showOnSlider();
}

void ValueSlider::setSingleStep(double step) {
  box_->setSingleStep(step);
  slider_->setSingleStep(std::max(1, static_cast<int>(std::lround(step / perStep_))));
}

void ValueSlider::setWrapping(bool wrapping) {
  box_->setWrapping(wrapping);
}

void ValueSlider::describe(const QString& name, const QString& accessibleName, const QString& toolTip) {
  slider_->setObjectName(name + QStringLiteral("Slider"));
  box_->setObjectName(name + QStringLiteral("Value"));
  for (QWidget* part : QWidgetList{slider_, box_}) {
    part->setAccessibleName(accessibleName);
    part->setToolTip(toolTip);
  }
}

void ValueSlider::showOnSlider() {
  const QSignalBlocker block(slider_);
  slider_->setValue(static_cast<int>(std::lround(box_->value() / perStep_)));
}

} // namespace innergs::ui
