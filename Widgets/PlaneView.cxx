#include "Widgets/PlaneView.h"

#include <QPainter>
#include <QPainterPath>
#include <QPixmap>

#include <vtkCamera.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImageData.h>
#include <vtkImageProperty.h>
#include <vtkImageSlice.h>
#include <vtkImageSliceMapper.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

namespace innergs::ui {

namespace {

/// A circular arrow.
QCursor turnCursor(const QWidget* widget) {
  const double ratio = widget->devicePixelRatioF();
  const int size = QFontMetrics(widget->font()).height() * 3 / 2;
  QPixmap pixmap(QSize(size, size) * ratio);
  pixmap.setDevicePixelRatio(ratio);
  pixmap.fill(Qt::transparent);
  QPainter painter(&pixmap);
  painter.setRenderHint(QPainter::Antialiasing);
  const QRectF box(0.2 * size, 0.2 * size, 0.6 * size, 0.6 * size);
  QPainterPath path;
  path.arcMoveTo(box, 60);
  path.arcTo(box, 60, 300);
  const QPointF end = path.currentPosition();
  path.moveTo(end + QPointF(-0.22 * size, -0.06 * size));
  path.lineTo(end);
  path.lineTo(end + QPointF(0.04 * size, -0.22 * size));
  painter.setPen(QPen(Qt::black, 0.18 * size, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
  painter.drawPath(path);
  painter.setPen(QPen(Qt::white, 0.09 * size, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
  painter.drawPath(path);
  painter.end();
  return QCursor(pixmap);
}

double angleOf(const QPointF& p) { // degrees, counter-clockwise on the screen
  return std::atan2(-p.y(), p.x()) * 180 / 3.14159265358979323846;
}

/// Diagonal stripes (RGBA) over the pixels of a plane of standard deviations where nothing was measured; null
/// if there are none, or if that is unknown.
vtkSmartPointer<vtkImageData> hatching(vtkImageData* deviation) {
  auto* measured = vtkUnsignedCharArray::SafeDownCast(
      deviation ? deviation->GetPointData()->GetArray("Measured") : nullptr);
  if (!measured || measured->GetRange()[0] > 0) return nullptr;
  constexpr int kStripe = 8; // pixels
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->CopyStructure(deviation);
  image->AllocateScalars(VTK_UNSIGNED_CHAR, 4);
  auto* out = static_cast<unsigned char*>(image->GetScalarPointer());
  const int columns = deviation->GetDimensions()[0];
  for (vtkIdType n = 0; n < measured->GetNumberOfTuples(); ++n, out += 4) {
    const bool stripe = (n % columns + n / columns) % kStripe < 2;
    const unsigned char colour[4] = {255, 170, 0, static_cast<unsigned char>(stripe ? 200 : 40)};
    std::copy_n(colour, 4, out);
    if (measured->GetValue(n)) out[3] = 0;
  }
  return image;
}

} // namespace

/// Letters, handles, hint and focus on top of the image.
class PlaneView::Overlay : public QWidget {
public:
  explicit Overlay(PlaneView* view) : QWidget(view), view_(view) {
    setAttribute(Qt::WA_TransparentForMouseEvents);
    setAttribute(Qt::WA_NoSystemBackground);
    setFocusPolicy(Qt::NoFocus);
  }

protected:
  void paintEvent(QPaintEvent*) override {
    QPainter painter(this);
    painter.setRenderHint(QPainter::Antialiasing);
    const QRectF all = rect();
    const double margin = 0.4 * fontMetrics().height();
    const QRectF inner = all.adjusted(margin, margin, -margin, -margin);
    if (!view_->message_.isEmpty()) {
      text(painter, inner, Qt::AlignCenter | Qt::TextWordWrap, view_->message_);
    } else {
      const QStringList letters = view_->letters();
      QFont bold = font();
      bold.setBold(true);
      painter.setFont(bold);
      text(painter, inner, Qt::AlignLeft | Qt::AlignVCenter, letters[0]);
      text(painter, inner, Qt::AlignRight | Qt::AlignVCenter, letters[1]);
      text(painter, inner, Qt::AlignHCenter | Qt::AlignTop, letters[2]);
      text(painter, inner, Qt::AlignHCenter | Qt::AlignBottom, letters[3]);
      painter.setFont(font());
      text(painter, inner.adjusted(0, 2 * fontMetrics().height(), 0, 0), Qt::AlignHCenter | Qt::AlignTop,
           view_->note_);
      if (view_->handlesShown_) {
        view_->handles().paint(painter, palette(), view_->hot_, view_->turned_);
        QRectF corner = inner; // next to the letter and the handle
        corner.setWidth(0.5 * inner.width() - 2.5 * fontMetrics().height());
        text(painter, corner, Qt::AlignLeft | Qt::AlignBottom | Qt::TextWordWrap, hintOf(view_->hot_));
      }
    }
    if (view_->hasFocus() && view_->message_.isEmpty()) {
      const QPointF middle = all.center();
      const double arm = 0.4 * fontMetrics().height();
      for (const QPen& pen : {QPen(QColor(0, 0, 0, 200), 3), QPen(Qt::white, 1)}) {
        painter.setPen(pen);
        painter.drawLine(middle - QPointF(arm, 0), middle + QPointF(arm, 0));
        painter.drawLine(middle - QPointF(0, arm), middle + QPointF(0, arm));
      }
    }
    if (view_->hasFocus()) {
      painter.setRenderHint(QPainter::Antialiasing, false);
      painter.setBrush(Qt::NoBrush);
      painter.setPen(QPen(palette().color(QPalette::Highlight), 2));
      painter.drawRect(rect().adjusted(1, 1, -1, -1));
    }
  }

private:
  /// White with a dark outline: legible on any image.
  static void text(QPainter& painter, const QRectF& box, int flags, const QString& words) {
    painter.setPen(QColor(0, 0, 0, 200));
    for (const QPointF& by : {QPointF(-1, 0), QPointF(1, 0), QPointF(0, -1), QPointF(0, 1)})
      painter.drawText(box.translated(by), flags, words);
    painter.setPen(Qt::white);
    painter.drawText(box, flags, words);
  }

  PlaneView* view_;
};

PlaneView::PlaneView(QWidget* parent) : QVTKOpenGLNativeWidget(parent), overlay_(new Overlay(this)) {
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  setRenderWindow(window);
  if (window->GetInteractor())
    window->GetInteractor()->SetInteractorStyle(nullptr); // this widget handles events
  window->AddRenderer(renderer_);
  renderer_->SetBackground(0, 0, 0);
  vtkCamera* camera = renderer_->GetActiveCamera();
  camera->ParallelProjectionOn();
  camera->SetFocalPoint(0, 0, 0);
  camera->SetPosition(0, 0, 1000);
  camera->SetViewUp(0, 1, 0);
  camera->SetClippingRange(1, 2000);
  mapper_->SetOrientationToZ();
  mapper_->BorderOn(); // half a pixel more: full pixels, not up to their centres
  slice_->SetMapper(mapper_);
  slice_->GetProperty()->SetInterpolationTypeToLinear();
  slice_->SetVisibility(false);
  renderer_->AddViewProp(slice_);
  unmeasuredMapper_->SetOrientationToZ();
  unmeasuredMapper_->BorderOn();
  unmeasured_->SetMapper(unmeasuredMapper_);
  unmeasured_->GetProperty()->SetInterpolationTypeToNearest();
  unmeasured_->ForceTranslucentOn();
  unmeasured_->SetVisibility(false);
  renderer_->AddViewProp(unmeasured_);
  redraw_.setSingleShot(true);
  redraw_.setInterval(0);
  connect(&redraw_, &QTimer::timeout, this, [this] {
    if (isValid() && isVisible()) renderWindow()->Render();
  });
}

PlaneView::~PlaneView() = default;

// Square, so that a plane fills the width.
QSize PlaneView::sizeHint() const {
  const int u = fontMetrics().height();
  return {24 * u, std::max(20 * u, testAttribute(Qt::WA_Resized) ? width() : 0)};
}

QSize PlaneView::minimumSizeHint() const {
  const int u = fontMetrics().height();
  return {10 * u, std::max(10 * u, testAttribute(Qt::WA_Resized) ? 3 * width() / 5 : 0)};
}

void PlaneView::setPose(const PlanePose& pose) {
  if (pose == pose_) return;
  pose_ = pose;
  placeImage();
  draw();
}

void PlaneView::setImage(const PlaneImage& image) {
  image_ = image;
  const auto place = [&](vtkImageData* pixels, double height, vtkImageSliceMapper* mapper,
                         vtkImageSlice* slice) {
    slice->SetVisibility(pixels != nullptr);
    if (!pixels) return;
    vtkNew<vtkImageData> placed; // the same pixels in plane coordinates
    placed->ShallowCopy(pixels);
    placed->SetOrigin(image.task.left, image.task.bottom, height);
    placed->SetSpacing(image.task.pixelSize, image.task.pixelSize, 1);
    mapper->SetInputData(placed);
  };
  place(image.shown(), 0, mapper_, slice_);
  place(hatching(image.deviation), 0.1, unmeasuredMapper_, unmeasured_); // over the plane
  placeImage();
  draw();
}

void PlaneView::clearImage() {
  image_ = {};
  slice_->SetVisibility(false);
  unmeasured_->SetVisibility(false);
  mapper_->SetInputData(nullptr);
  draw();
}

// If the plane has only been shifted or rotated within itself, moves the current image at once.
void PlaneView::placeImage() {
  if (!image_.image) return;
  const Mat3 now = pose_.axes(), then = image_.task.pose.axes();
  const Mat3 turn = transpose(now) * then;
  const Vec3 shift = transpose(now) * (image_.task.pose.origin - pose_.origin);
  vtkNew<vtkMatrix4x4> matrix;
  if (turn[2][2] > 1 - 1e-9 && std::abs(shift[2]) < 1e-6)
    for (int r = 0; r < 2; ++r) {
      for (int c = 0; c < 2; ++c)
        matrix->SetElement(r, c, turn[r][c]);
      matrix->SetElement(r, 3, shift[r]);
    }
  slice_->SetUserMatrix(matrix);
  unmeasured_->SetUserMatrix(matrix);
}

void PlaneView::setMessage(const QString& message) {
  if (message == message_) return;
  message_ = message;
  overlay_->update();
}

void PlaneView::setNote(const QString& note) {
  if (note == note_) return;
  note_ = note;
  overlay_->update();
}

void PlaneView::setWindow(double lower, double upper) {
  lower_ = lower;
  upper_ = upper;
  slice_->GetProperty()->SetColorWindow(upper - lower);
  slice_->GetProperty()->SetColorLevel(0.5 * (upper + lower));
  draw();
}

void PlaneView::setHandlesShown(bool shown) {
  handlesShown_ = shown;
  setHot(PlaneHandle::None);
  overlay_->update();
}

void PlaneView::fit(double left, double right, double bottom, double top) {
  fitted_[0] = left, fitted_[1] = right, fitted_[2] = bottom, fitted_[3] = top;
  const double high = std::max({std::abs(bottom), std::abs(top), 1e-3}),
               wide = std::max(std::abs(left), std::abs(right));
  halfHeight_ = 1.05 * std::max(high, wide * height() / std::max(1, width()));
  zoomed_ = false;
  draw();
}

double PlaneView::scale() const {
  return 2 * halfHeight_ / std::max(1, height());
}

QStringList PlaneView::letters() const {
  const Mat3 axes = pose_.axes();
  const Vec3 right = column(axes, 0), up = column(axes, 1);
  return {directionLetters(-1 * right), directionLetters(right), directionLetters(up),
          directionLetters(-1 * up)};
}

QPointF PlaneView::planeAt(const QPointF& p) const {
  return {(p.x() - 0.5 * width()) * scale(), (0.5 * height() - p.y()) * scale()};
}

QPointF PlaneView::widgetAt(const QPointF& p) const {
  return {p.x() / scale() + 0.5 * width(), 0.5 * height() - p.y() / scale()};
}

PlaneHandles PlaneView::handles() const {
  return {QSizeF(size()), static_cast<double>(fontMetrics().height())};
}

void PlaneView::draw() {
  renderer_->GetActiveCamera()->SetParallelScale(halfHeight_);
  overlay_->update();
  redraw_.start();
}

void PlaneView::edit(const PlanePose& pose) {
  if (pose == pose_) return;
  setPose(pose);
  Q_EMIT poseEdited(pose_);
}

void PlaneView::zoom(double factor) {
  halfHeight_ = std::clamp(halfHeight_ * factor, 0.5, 5000.);
  zoomed_ = true;
  draw();
}

void PlaneView::setHot(PlaneHandle handle) {
  if (handle == hot_) return;
  hot_ = handle;
  switch (handle) {
  case PlaneHandle::None:
    unsetCursor();
    break;
  case PlaneHandle::Move:
  case PlaneHandle::TiltHorizontal:
    setCursor(Qt::SizeVerCursor);
    break;
  case PlaneHandle::TiltVertical:
    setCursor(Qt::SizeHorCursor);
    break;
  case PlaneHandle::Turn:
    setCursor(turnCursor(this));
    break;
  }
  overlay_->update();
}

void PlaneView::leaveEvent(QEvent* event) {
  QVTKOpenGLNativeWidget::leaveEvent(event);
  if (drag_ == Drag::None) setHot(PlaneHandle::None);
  Q_EMIT left();
}

void PlaneView::resizeEvent(QResizeEvent* event) {
  QVTKOpenGLNativeWidget::resizeEvent(event);
  overlay_->setGeometry(rect());
  if (event->oldSize().width() != width()) updateGeometry();
  if (!zoomed_) fit(fitted_[0], fitted_[1], fitted_[2], fitted_[3]);
  draw();
}

void PlaneView::focusInEvent(QFocusEvent* event) {
  QVTKOpenGLNativeWidget::focusInEvent(event);
  overlay_->update();
  Q_EMIT focusChanged(true);
}

void PlaneView::focusOutEvent(QFocusEvent* event) {
  QVTKOpenGLNativeWidget::focusOutEvent(event);
  overlay_->update();
  Q_EMIT focusChanged(false);
}

void PlaneView::showEvent(QShowEvent* event) {
  QVTKOpenGLNativeWidget::showEvent(event);
  draw();
}

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

// As if the mouse moved the near side of the patient; the plane's rotation then depends on the side that the
// normal points to.
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
    QWidget::keyPressEvent(event); // keeps VTK's keys from acting
    return;
  }
  event->accept();
  if (message_.isEmpty()) edit(pose);
}

} // namespace innergs::ui
