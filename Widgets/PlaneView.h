#pragma once
#include "Widgets/PlaneHandles.h"
#include "Widgets/PlaneWorker.h"
#include "Widgets/ViewGestures.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QStringList>
#include <QTimer>

#include <vtkNew.h>

class vtkImageSlice;
class vtkImageSliceMapper;
class vtkRenderer;

namespace innergs::ui {

/// Shows a plane of a model (x right, y up) with the letters of its directions, and lets the user rotate and
/// move the plane by handles. Left drag: window and level; middle or Shift+left: pan; right or Ctrl+wheel:
/// zoom; wheel: along the normal. Keys: arrows tilt, Shift+arrows pan, Ctrl+left/right rotate, Page Up/Down
/// move, +/− zoom, Home fits; with the keyboard focus, a cross marks the centre. It computes nothing: its
/// owner provides the images.
class PlaneView : public QVTKOpenGLNativeWidget {
  Q_OBJECT
public:
  explicit PlaneView(QWidget* parent = nullptr);
  ~PlaneView() override;

  const PlanePose& pose() const { return pose_; }
  void setPose(const PlanePose& pose);
  /// image: null hides it. A standard deviation is hatched where nothing was measured. It keeps its position
  /// in the patient while only the plane's own axes move.
  void setImage(const PlaneImage& image);
  void clearImage();
  const PlaneImage& image() const { return image_; }
  /// A line in the centre instead of the letters; "" none.
  void setMessage(const QString& message);
  /// A line on top of the image; "" none.
  void setNote(const QString& note);
  const QString& note() const { return note_; }
  void setWindow(double lower, double upper);
  double lower() const { return lower_; }
  double upper() const { return upper_; }
  void setHandlesShown(bool shown);
  /// mm that one step of the wheel moves the plane.
  void setStep(double mm) { step_ = mm; }
  /// Fits this box in plane coordinates (mm; xmin, xmax, ymin, ymax) into the view.
  void fit(double left, double right, double bottom, double top);
  /// mm per pixel of the widget.
  double scale() const;

  /// Direction letters at the centre of the left, right, top and bottom edge.
  QStringList letters() const;
  QPointF planeAt(const QPointF& widgetPoint) const;
  QPointF widgetAt(const QPointF& planePoint) const;
  PlaneHandles handles() const;
  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;

Q_SIGNALS:
  /// Edited by the user; pose() has the new value already.
  void poseEdited(const innergs::ui::PlanePose& pose);
  /// Whether the user is dragging the plane.
  void draggingChanged(bool dragging);
  void windowEdited(double lower, double upper);
  /// mm in the plane.
  void hovered(const QPointF& planePoint);
  void left();
  /// Whether the view has the keyboard focus.
  void focusChanged(bool focus);
  void homeAsked();

protected:
  void mousePressEvent(QMouseEvent* event) override;
  void mouseMoveEvent(QMouseEvent* event) override;
  void mouseReleaseEvent(QMouseEvent* event) override;
  void wheelEvent(QWheelEvent* event) override;
  void keyPressEvent(QKeyEvent* event) override;
  void leaveEvent(QEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void focusInEvent(QFocusEvent* event) override;
  void focusOutEvent(QFocusEvent* event) override;
  void showEvent(QShowEvent* event) override;

private:
  enum class Drag { None, Handle, Window, Pan, Zoom };
  class Overlay;
  void dragTo(const QPointF& point);
  void turnTo(const QPointF& point);
  void edit(const PlanePose& pose);
  void zoom(double factor);
  void setHot(PlaneHandle handle);
  void placeImage();
  void draw();

  PlanePose pose_, dragPose_;
  PlaneImage image_;
  QString message_, note_;
  bool handlesShown_ = true;
  double lower_ = 0, upper_ = 1, dragLower_ = 0, dragUpper_ = 1;
  double halfHeight_ = 100, dragHalfHeight_ = 100; // mm
  double step_ = 1, turned_ = 0;
  WheelSteps wheel_;
  double fitted_[4] = {-100, 100, -100, 100};
  bool zoomed_ = false; // by the user
  Drag drag_ = Drag::None;
  Qt::MouseButton button_ = Qt::NoButton;
  QPointF from_;
  PlaneHandle hot_ = PlaneHandle::None;
  QTimer redraw_;
  QWidget* overlay_; // an Overlay
  vtkNew<vtkRenderer> renderer_;
  vtkNew<vtkImageSliceMapper> mapper_, unmeasuredMapper_;
  vtkNew<vtkImageSlice> slice_, unmeasured_; // hatched where nothing was measured
};

} // namespace innergs::ui
