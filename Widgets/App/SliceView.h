#pragma once
#include "Widgets/App/ViewState.h"
#include "Widgets/ViewGestures.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QPoint>

#include <memory>

namespace innergs::app {

/// One plane through the shown volume, as radiologists look at it: axial from the feet, coronal from the
/// front, sagittal from the left. A click moves the crosshair of all views, the wheel goes through the
/// slices, a drag with the left button changes window and level, with the right one zooms, with the middle
/// one pans. Keys: arrows and Page Up/Down go through the slices, Shift+arrows move, +/− zoom, Home fits.
class SliceView : public QVTKOpenGLNativeWidget {
  Q_OBJECT
public:
  /// axis: the RAS axis that the plane lies across: 0 sagittal, 1 coronal, 2 axial.
  SliceView(ViewState* state, int axis, QWidget* parent = nullptr);
  ~SliceView() override;

  int axis() const { return axis_; }
  static QString nameOf(int axis);
  /// Position across the slices, RAS mm.
  double position() const;
  void stepSlices(int count);
  /// Fits the whole volume into the view.
  void fit();
  /// RAS of a point of the widget (in its own pixels).
  Vec3 toRAS(const QPointF& at) const;
  /// The inverse, for scripts and tests.
  QPointF fromRAS(const Vec3& ras) const;
  /// The letters at the left, right, top and bottom edge.
  std::array<QChar, 4> letters() const;

Q_SIGNALS:
  /// The place and value under the mouse, or at the crosshair while this view has the keyboard focus; else
  /// "".
  void pointed(const QString& text);
  void doubleClicked();

protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void focusInEvent(QFocusEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;

private:
  void showVolume();
  void showWindow();
  void showPlane();
  void showOverlay();
  void placeLetters();
  void render();
  double millimetresPerPixel() const;
  void zoom(double factor);
  /// Pans, mm.
  void pan(double right, double up);
  void pointCrosshair();

  ViewState* state_;
  const int axis_;
  QPoint pressed_, last_;
  Qt::MouseButton button_ = Qt::NoButton;
  bool dragging_ = false, fitted_ = false;
  ui::WheelSteps wheel_;
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

} // namespace innergs::app
