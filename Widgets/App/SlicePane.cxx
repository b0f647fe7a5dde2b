#include "Widgets/App/SlicePane.h"

#include "Widgets/PanelTools.h"

#include <QDoubleSpinBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QSignalBlocker>
#include <QSlider>

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs::app {

SlicePane::SlicePane(ViewState* state, int axis, QWidget* parent)
    : QWidget(parent), state_(state), view_(new SliceView(state, axis, this)),
      slider_(new QSlider(Qt::Horizontal, this)), position_(new QDoubleSpinBox(this)) {
  auto* name = new QLabel(SliceView::nameOf(axis), this);
  name->setBuddy(slider_);
  ui::named(slider_, "slider", tr("Scroll through the slices; the number next to it is the position in mm."));
  slider_->setAccessibleName(tr("%1 slice").arg(name->text()));
  position_->setAccessibleName(tr("%1 position").arg(name->text()));
  position_->setDecimals(1);
  position_->setPrefix(QLatin1Char("RAS"[axis]) + QStringLiteral(" "));
  position_->setSuffix(tr(" mm"));
  static const char* const ends[] = {QT_TR_NOOP("Position in RAS mm, positive to the patient's right"),
                                     QT_TR_NOOP("Position in RAS mm, positive to the patient's front"),
                                     QT_TR_NOOP("Position in RAS mm, positive to the patient's head")};
  ui::named(position_, "position", tr(ends[axis]));
  position_->setKeyboardTracking(false);
  auto* top = new QHBoxLayout;
  const int gap = fontMetrics().averageCharWidth() / 2;
  top->setContentsMargins(2 * gap, gap / 2, gap, gap / 2);
  top->addWidget(name);
  top->addWidget(slider_, 1);
  top->addWidget(position_);
  auto* all = new QVBoxLayout(this);
  const int frame = frameWidth(this);
  all->setContentsMargins(frame, 0, frame, frame);
  all->setSpacing(frame);
  all->addLayout(top);
  all->addWidget(view_, 1);
  connect(state, &ViewState::volumeChanged, this, &SlicePane::showRange);
  connect(state, &ViewState::crosshairChanged, this, &SlicePane::showPosition);
  const auto move = [this](double to) {
    Vec3 cross = state_->crosshair();
    cross[view_->axis()] = to;
    state_->setCrosshair(cross);
  };
  connect(slider_, &QSlider::valueChanged, this, [this, move](int value) {
    const std::array<double, 6> box = state_->bounds();
    const double step = state_->stepAlong(view_->axis());
    move(box[2 * view_->axis()] + (value + 0.5) * step);
  });
  connect(position_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, move);
  showRange();
}

void SlicePane::showRange() {
  const int axis = view_->axis();
  const std::array<double, 6> box = state_->bounds();
  const double step = state_->stepAlong(axis), length = box[2 * axis + 1] - box[2 * axis];
  const bool any = state_->volume() != nullptr;
  slider_->setEnabled(any);
  position_->setEnabled(any);
  {
    const QSignalBlocker one(slider_), two(position_);
    slider_->setRange(0, std::max(0, static_cast<int>(std::lround(length / step)) - 1));
    slider_->setPageStep(10);
    position_->setRange(box[2 * axis], box[2 * axis + 1]);
    position_->setSingleStep(step);
  }
  showPosition();
}

void SlicePane::showPosition() {
  const int axis = view_->axis();
  const double step = state_->stepAlong(axis), at = state_->crosshair()[axis];
  const QSignalBlocker one(slider_), two(position_);
  slider_->setValue(static_cast<int>(std::floor((at - state_->bounds()[2 * axis]) / step)));
  position_->setValue(at);
}

int SlicePane::frameWidth(const QWidget* widget) {
  return std::max(2, widget->fontMetrics().height() / 8);
}

} // namespace innergs::app
