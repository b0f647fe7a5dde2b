#pragma once
#include <QKeyEvent>
#include <QMouseEvent>
#include <QPointF>
#include <QWheelEvent>

#include <cmath>

/// The gestures common to all views of a plane.
namespace innergs::ui {

/// The position in the widget's own pixels.
inline QPointF pointOf(const QMouseEvent* event) {
#if QT_VERSION >= QT_VERSION_CHECK(6, 0, 0)
  return event->position();
#else
  return event->localPos();
#endif
}

/// Counts the steps of a wheel; adds up the small ones of fine wheels and trackpads.
class WheelSteps {
public:
  /// The whole steps since the last call; positive is up.
  int take(const QWheelEvent* event) {
    // Qt turns the wheel sideways while Alt is held.
    angle_ += event->modifiers() & Qt::AltModifier ? event->angleDelta().x() : event->angleDelta().y();
    const int steps = angle_ / kStep;
    angle_ -= kStep * steps;
    return steps;
  }
  /// The zoom factor on the length that the view shows.
  static double zoomOf(const QWheelEvent* event) {
    return std::pow(0.85, static_cast<double>(event->angleDelta().y()) / kStep);
  }

private:
  static constexpr int kStep = 120; // eighths of a degree
  int angle_ = 0;
};

/// Likewise for a drag `down` pixels downwards, and for a key; 1: not a zoom key.
inline double zoomOfDrag(double down) {
  return std::exp(down / 150);
}
inline double zoomOfKey(int key) {
  return key == Qt::Key_Plus || key == Qt::Key_Equal ? 0.85 : key == Qt::Key_Minus ? 1 / 0.85 : 1;
}
/// How far (right, up; in heights of the view) Shift and an arrow key pan; null: not such a key.
inline QPointF panOfKey(const QKeyEvent* event) {
  constexpr double step = 0.05;
  if (!(event->modifiers() & Qt::ShiftModifier)) return {};
  switch (event->key()) {
  case Qt::Key_Left:
    return {-step, 0};
  case Qt::Key_Right:
    return {step, 0};
  case Qt::Key_Up:
    return {0, step};
  case Qt::Key_Down:
    return {0, -step};
  default:
    return {};
  }
}

} // namespace innergs::ui
