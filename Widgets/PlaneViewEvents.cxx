// What the mouse and the keys do in the view.
#include "Widgets/PlaneView.h"

#include <algorithm>
#include <cmath>

namespace innergs::ui {

namespace {

double angleOf(const QPointF& p) { // degrees, counter-clockwise on the screen
  return std::atan2(-p.y(), p.x()) * 180 / 3.14159265358979323846;
}

} // namespace

void PlaneView::mousePressEvent(QMouseEvent* event) {
  event->accept();
  if (drag_ != Drag::None || !message_.isEmpty()) return;
  from_ = pointOf(event);
  button_ = event->button();
  dragPose_ = pose_;
  dragLower_ = lower_, dragUpper_ = upper_;
  dragHalfHeight_ = halfHeight_;
  const bool shift = event->modifiers() & Qt::ShiftModifier;
  setHot(handlesShown_ && button_ == Qt::LeftButton && !shift ? handles().at(from_) : PlaneHandle::None);
  if (hot_ != PlaneHandle::None)
    drag_ = Drag::Handle;
  else if (button_ == Qt::MiddleButton || (button_ == Qt::LeftButton && shift))
    drag_ = Drag::Pan, setCursor(Qt::ClosedHandCursor);
  else if (button_ == Qt::LeftButton)
    drag_ = Drag::Window;
  else if (button_ == Qt::RightButton)
    drag_ = Drag::Zoom, setCursor(Qt::SizeVerCursor);
  if (drag_ == Drag::Handle || drag_ == Drag::Pan) Q_EMIT draggingChanged(true);
}

void PlaneView::mouseMoveEvent(QMouseEvent* event) {
  event->accept();
  const QPointF point = pointOf(event);
  if (drag_ == Drag::None) {
    setHot(handlesShown_ && message_.isEmpty() ? handles().at(point) : PlaneHandle::None);
  } else {
    dragTo(point);
  }
  if (message_.isEmpty()) Q_EMIT hovered(planeAt(point));
}

void PlaneView::mouseReleaseEvent(QMouseEvent* event) {
  event->accept();
  if (drag_ == Drag::None || event->button() != button_) return;
  const bool dragged = drag_ == Drag::Handle || drag_ == Drag::Pan;
  drag_ = Drag::None;
  turned_ = 0;
  hot_ = PlaneHandle::None;
  unsetCursor();
  setHot(handlesShown_ ? handles().at(pointOf(event)) : PlaneHandle::None);
  overlay_->update();
  if (dragged) Q_EMIT draggingChanged(false);
}

void PlaneView::dragTo(const QPointF& point) {
  const QPointF by = point - from_; // y down
  switch (drag_) {
  case Drag::None:
    break;
  case Drag::Handle:
    turnTo(point);
    break;
  case Drag::Pan: {
    PlanePose pose = dragPose_;
    pose.move(-by.x() * scale(), by.y() * scale(), 0);
    edit(pose);
    break;
  }
  case Drag::Window: {
    const double width = dragUpper_ - dragLower_, perPixel = std::max(width, 1e-6) / 250;
    const double window = std::max(width + by.x() * perPixel, 0.01 * width);
    const double level = 0.5 * (dragLower_ + dragUpper_) - by.y() * perPixel;
    setWindow(level - 0.5 * window, level + 0.5 * window);
    Q_EMIT windowEdited(lower_, upper_);
    break;
  }
  case Drag::Zoom:
    halfHeight_ = dragHalfHeight_;
    zoom(zoomOfDrag(by.y())); // up: nearer
    break;
  }
}

// As if the near side of the patient were moved with the mouse: how the plane turns then depends on the side
// that the normal points to.
void PlaneView::turnTo(const QPointF& point) {
  constexpr double perRadian = 180 / 3.14159265358979323846;
  const QPointF by = point - from_, middle = handles().centre();
  const double radius = handles().radius(), side = determinant(dragPose_.axes()) > 0 ? 1 : -1;
  PlanePose pose = dragPose_;
  if (hot_ == PlaneHandle::Move) {
    pose.move(0, 0, -by.y() * scale());
  } else if (hot_ == PlaneHandle::TiltHorizontal) {
    pose.turn(0, -side * by.y() / radius * perRadian);
  } else if (hot_ == PlaneHandle::TiltVertical) {
    pose.turn(1, -side * by.x() / radius * perRadian);
  } else if (hot_ == PlaneHandle::Turn) {
    turned_ = std::remainder(angleOf(point - middle) - angleOf(from_ - middle), 360);
    pose.turn(2, -turned_);
  }
  edit(pose);
}

void PlaneView::wheelEvent(QWheelEvent* event) {
  event->accept();
  if (!message_.isEmpty()) return;
  if (event->modifiers() & Qt::ControlModifier) {
    zoom(WheelSteps::zoomOf(event));
    return;
  }
  const int steps = wheel_.take(event);
  PlanePose pose = pose_;
  pose.move(0, 0, steps * step_);
  edit(pose);
}

void PlaneView::keyPressEvent(QKeyEvent* event) {
  PlanePose pose = pose_;
  const bool control = event->modifiers() & Qt::ControlModifier;
  if (const QPointF way = panOfKey(event); !way.isNull()) {
    pose.move(way.x() * 2 * halfHeight_, way.y() * 2 * halfHeight_, 0);
    event->accept();
    if (message_.isEmpty()) edit(pose);
    return;
  }
  switch (event->key()) {
  case Qt::Key_Left:
  case Qt::Key_Right: {
    const double way = event->key() == Qt::Key_Right ? 1 : -1;
    pose.turn(control ? 2 : 1, way);
    break;
  }
  case Qt::Key_Up:
  case Qt::Key_Down:
    pose.turn(0, event->key() == Qt::Key_Up ? 1 : -1);
    break;
  case Qt::Key_PageUp:
    pose.move(0, 0, step_);
    break;
  case Qt::Key_PageDown:
    pose.move(0, 0, -step_);
    break;
  case Qt::Key_Plus:
  case Qt::Key_Equal:
  case Qt::Key_Minus:
    zoom(zoomOfKey(event->key()));
    break;
  case Qt::Key_Home:
    event->accept();
    Q_EMIT homeAsked();
    return;
  default:
    QWidget::keyPressEvent(event); // not VTK's keys
    return;
  }
  event->accept();
  if (message_.isEmpty()) edit(pose);
}

} // namespace innergs::ui
