#include "Widgets/App/SliceView.h"

#include "Widgets/App/SegmentItems.h"

#include <vtkActor2D.h>
#include <vtkCamera.h>
#include <vtkCoordinate.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImageProperty.h>
#include <vtkImageResliceMapper.h>
#include <vtkImageSlice.h>
#include <vtkLineSource.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper2D.h>
#include <vtkProperty2D.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>

#include <QApplication>
#include <QFontMetrics>
#include <QKeyEvent>
#include <QMouseEvent>
#include <QWheelEvent>

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs::app {
namespace {

// To the right and to the top of the widget, RAS; Slicer's and radiologists' convention.
constexpr Vec3 kRight[] = {{0, -1, 0}, {-1, 0, 0}, {-1, 0, 0}};
constexpr Vec3 kUp[] = {{0, 0, 1}, {0, 0, 1}, {0, 1, 0}};
// Red, yellow, green as in Slicer: sagittal, coronal, axial.
constexpr double kColour[][3] = {{0.93, 0.84, 0.30}, {0.43, 0.69, 0.29}, {0.95, 0.29, 0.20}};

QChar letterOf(const Vec3& direction) {
  static const char* const letters[] = {"RL", "AP", "SI"};
  for (int a = 0; a < 3; ++a)
    if (std::abs(direction[a]) > 0.5) return QLatin1Char(letters[a][direction[a] < 0]);
  return {};
}

} // namespace

struct SliceView::Scene {
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkImageResliceMapper> mapper;
  vtkNew<vtkImageSlice> slice;
  vtkNew<vtkRenderer> overlayRenderer; // a layer of its own: both slices lie in one plane
  vtkNew<vtkImageResliceMapper> overlayMapper;
  vtkNew<vtkImageSlice> overlay;
  vtkNew<vtkLineSource> lines[2];
  vtkNew<vtkActor2D> cross[2];
  vtkNew<vtkTextActor> letters[4], place;
};

SliceView::SliceView(ViewState* state, int axis, QWidget* parent)
    : QVTKOpenGLNativeWidget(parent), state_(state), axis_(axis), scene_(std::make_unique<Scene>()) {
  static const char* const names[] = {"sagittalView", "coronalView", "axialView"};
  setObjectName(QString::fromLatin1(names[axis]));
  setAccessibleName(nameOf(axis));
  setMouseTracking(true);
  setFocusPolicy(Qt::StrongFocus);
  setToolTip(
      tr("Click: crosshair in all views. Drag: window and level. Wheel: slices.\n"
         "Right drag or Ctrl+wheel: zoom. Middle drag: move. Double click: this view alone.\n"
         "Keys: arrows, Page Up and Page Down: slices; Shift+arrows: move; + and −: zoom; Home: all of it.\n"
         "While this view has the keyboard focus, the value at the crosshair is shown."));
  Scene& s = *scene_;
  s.window->SetMultiSamples(0);
  setRenderWindow(s.window.Get());
  s.window->GetInteractor()->SetInteractorStyle(nullptr); // the widget's own
  s.window->AddRenderer(s.renderer);
  s.renderer->SetBackground(0, 0, 0);
  s.mapper->SliceFacesCameraOn();
  s.mapper->SliceAtFocalPointOn();
  s.mapper->SeparateWindowLevelOperationOn();
  s.slice->SetMapper(s.mapper);
  s.slice->GetProperty()->SetInterpolationTypeToLinear();
  s.slice->VisibilityOff();
  s.renderer->AddViewProp(s.slice);
  s.window->SetNumberOfLayers(2);
  s.overlayRenderer->SetLayer(1);
  s.overlayRenderer->InteractiveOff();
  s.overlayRenderer->SetActiveCamera(s.renderer->GetActiveCamera());
  s.window->AddRenderer(s.overlayRenderer);
  s.overlayMapper->SliceFacesCameraOn();
  s.overlayMapper->SliceAtFocalPointOn();
  s.overlayMapper->BorderOn();
  s.overlay->SetMapper(s.overlayMapper);
  s.overlay->GetProperty()->SetInterpolationTypeToNearest();
  s.overlay->GetProperty()->UseLookupTableScalarRangeOn();
  s.overlay->VisibilityOff();
  s.overlayRenderer->AddViewProp(s.overlay);
  for (int n = 0; n < 2; ++n) {
    vtkNew<vtkPolyDataMapper2D> mapper;
    mapper->SetInputConnection(s.lines[n]->GetOutputPort());
    vtkNew<vtkCoordinate> world;
    world->SetCoordinateSystemToWorld();
    mapper->SetTransformCoordinate(world);
    s.cross[n]->SetMapper(mapper);
    const int across = kRight[axis][0] != 0 ? 0 : 1; // the RAS axis that the line n stands for
    const int other = n == 0 ? across : 3 - across - axis;
    s.cross[n]->GetProperty()->SetColor(kColour[other][0], kColour[other][1], kColour[other][2]);
    s.cross[n]->GetProperty()->SetOpacity(0.7);
    s.cross[n]->VisibilityOff();
    s.renderer->AddActor2D(s.cross[n]);
  }
  for (vtkTextActor* text :
       {s.letters[0].Get(), s.letters[1].Get(), s.letters[2].Get(), s.letters[3].Get(), s.place.Get()}) {
    text->GetTextProperty()->SetColor(0.85, 0.85, 0.85);
    text->GetTextProperty()->ShadowOn();
    text->VisibilityOff();
    s.renderer->AddActor2D(text);
  }
  const std::array<QChar, 4> edge = letters();
  for (int n = 0; n < 4; ++n)
    s.letters[n]->SetInput(QString(edge[n]).toUtf8().constData());
  s.renderer->GetActiveCamera()->ParallelProjectionOn();
  connect(state, &ViewState::volumeChanged, this, &SliceView::showVolume);
  connect(state, &ViewState::windowChanged, this, &SliceView::showWindow);
  connect(state, &ViewState::crosshairChanged, this, &SliceView::showPlane);
  connect(state, &ViewState::overlayChanged, this, &SliceView::showOverlay);
  connect(state, &ViewState::volumeChanged, this, &SliceView::pointCrosshair);
  connect(state, &ViewState::crosshairChanged, this, &SliceView::pointCrosshair);
  connect(state, &ViewState::placeChanged, this, [this] {
    fitted_ = false; // so that fit() happens later if the view has no size yet
    fit();
  });
  showVolume();
}

SliceView::~SliceView() = default;

QString SliceView::nameOf(int axis) {
  return axis == 0 ? tr("Sagittal") : axis == 1 ? tr("Coronal") : tr("Axial");
}

std::array<QChar, 4> SliceView::letters() const {
  const Vec3 right = kRight[axis_], up = kUp[axis_];
  return {letterOf(-1 * right), letterOf(right), letterOf(up), letterOf(-1 * up)};
}

double SliceView::position() const {
  return state_->crosshair()[axis_];
}

//------------------------------------------------------------------------------
// What is shown.

void SliceView::showVolume() {
  Scene& s = *scene_;
  const auto item = state_->volume();
  for (vtkProp* prop : std::initializer_list<vtkProp*>{s.slice, s.cross[0], s.cross[1], s.place, s.letters[0],
                                                       s.letters[1], s.letters[2], s.letters[3]})
    prop->SetVisibility(item != nullptr);
  s.overlay->SetVisibility(item && state_->overlay());
  if (!item) {
    s.mapper->RemoveAllInputs();
    fitted_ = false;
    render();
    return;
  }
  s.mapper->SetInputData(item->image);
  s.slice->SetUserMatrix(item->ijkToRAS);
  showWindow();
  if (!fitted_) fit();
  showPlane();
}

void SliceView::showOverlay() {
  Scene& s = *scene_;
  const auto overlay = state_->overlay();
  s.overlay->SetVisibility(overlay && state_->volume());
  if (overlay) {
    vtkNew<vtkLookupTable> colors;
    const auto labels = static_cast<int>(overlay->colors.size());
    colors->SetNumberOfTableValues(labels + 1);
    colors->SetTableRange(0, labels);
    colors->SetTableValue(0, 0, 0, 0, 0);
    for (int n = 0; n < labels; ++n) {
      const auto& c = overlay->colors[static_cast<std::size_t>(n)];
      colors->SetTableValue(n + 1, c[0], c[1], c[2], 0.45);
    }
    s.overlay->GetProperty()->SetLookupTable(colors);
    s.overlayMapper->SetInputData(overlay->labels);
    s.overlay->SetUserMatrix(overlay->ijkToRAS);
  }
  render();
}

void SliceView::showWindow() {
  if (const auto item = state_->volume()) {
    vtkImageProperty* property = scene_->slice->GetProperty();
    property->SetColorWindow(item->window->upper - item->window->lower);
    property->SetColorLevel(0.5 * (item->window->upper + item->window->lower));
  }
  render();
}

void SliceView::fit() {
  const auto item = state_->volume();
  if (!item || width() < 2 || height() < 2) return;
  fitted_ = true;
  const std::array<double, 6> box = state_->bounds();
  Vec3 extent, centre;
  for (int a = 0; a < 3; ++a) {
    extent[a] = box[2 * a + 1] - box[2 * a];
    centre[a] = 0.5 * (box[2 * a + 1] + box[2 * a]);
  }
  const double wide = std::abs(dot(extent, kRight[axis_])), high = std::abs(dot(extent, kUp[axis_]));
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  camera->SetParallelScale(0.52 * std::max(high, wide * height() / width()));
  centre[axis_] = position();
  camera->SetFocalPoint(centre.data());
  showPlane();
}

void SliceView::showPlane() {
  Scene& s = *scene_;
  const Vec3 place = state_->crosshair();
  vtkCamera* camera = s.renderer->GetActiveCamera();
  Vec3 focus;
  camera->GetFocalPoint(focus.data());
  focus[axis_] = place[axis_];
  const Vec3 &right = kRight[axis_], &up = kUp[axis_];
  constexpr double distance = 1000; // mm
  camera->SetFocalPoint(focus.data());
  camera->SetPosition((focus + distance * cross(right, up)).data()); // on the side of the eye
  camera->SetViewUp(up.data());
  camera->SetClippingRange(distance - 500, distance + 500);
  constexpr double reach = 5000;
  for (int n = 0; n < 2; ++n) {
    const Vec3 along = reach * (n == 0 ? up : right);
    s.lines[n]->SetPoint1((place - along).data());
    s.lines[n]->SetPoint2((place + along).data());
  }
  static const char* const ends[] = {"RL", "AP", "SI"};
  s.place->SetInput(QStringLiteral("%1 %2 mm")
                        .arg(QLatin1Char(ends[axis_][place[axis_] < 0]))
                        .arg(std::abs(place[axis_]), 0, 'f', 1)
                        .toUtf8()
                        .constData());
  render();
}

void SliceView::placeLetters() {
  Scene& s = *scene_;
  const double ratio = devicePixelRatioF();
  const int size = static_cast<int>(QFontMetrics(font()).ascent() * 1.2); // VTK scales it as the screen is
  const double w = ratio * width(), h = ratio * height(), margin = 0.4 * ratio * size;
  const double x[] = {margin, w - margin, w / 2, w / 2}, y[] = {h / 2, h / 2, h - margin, margin};
  for (int n = 0; n < 4; ++n) {
    vtkTextProperty* text = s.letters[n]->GetTextProperty();
    text->SetFontSize(size);
    text->BoldOn();
    n == 0   ? text->SetJustificationToLeft()
    : n == 1 ? text->SetJustificationToRight()
             : text->SetJustificationToCentered();
    n == 2   ? text->SetVerticalJustificationToTop()
    : n == 3 ? text->SetVerticalJustificationToBottom()
             : text->SetVerticalJustificationToCentered();
    s.letters[n]->SetDisplayPosition(static_cast<int>(x[n]), static_cast<int>(y[n]));
  }
  s.place->GetTextProperty()->SetFontSize(size);
  s.place->GetTextProperty()->SetVerticalJustificationToBottom();
  s.place->SetDisplayPosition(static_cast<int>(margin), static_cast<int>(margin));
}

void SliceView::render() {
  state_->turns().add(this, [this] {
    if (isVisible()) scene_->window->Render();
  });
}

void SliceView::resizeEvent(QResizeEvent* event) {
  QVTKOpenGLNativeWidget::resizeEvent(event);
  placeLetters();
  if (!fitted_) fit();
  render();
}

//------------------------------------------------------------------------------
// Positions.

double SliceView::millimetresPerPixel() const {
  return 2 * scene_->renderer->GetActiveCamera()->GetParallelScale() / std::max(1, height());
}

Vec3 SliceView::toRAS(const QPointF& at) const {
  const double scale = millimetresPerPixel();
  const double right = (at.x() - 0.5 * width()) * scale, up = (0.5 * height() - at.y()) * scale;
  Vec3 ras;
  scene_->renderer->GetActiveCamera()->GetFocalPoint(ras.data());
  for (int a = 0; a < 3; ++a)
    ras[a] += right * kRight[axis_][a] + up * kUp[axis_][a];
  ras[axis_] = position();
  return ras;
}

QPointF SliceView::fromRAS(const Vec3& ras) const {
  Vec3 focus;
  scene_->renderer->GetActiveCamera()->GetFocalPoint(focus.data());
  const Vec3 from = ras - focus;
  const double scale = millimetresPerPixel();
  return {0.5 * width() + dot(from, kRight[axis_]) / scale, 0.5 * height() - dot(from, kUp[axis_]) / scale};
}

void SliceView::zoom(double factor) {
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  camera->SetParallelScale(camera->GetParallelScale() * factor);
  render();
}

void SliceView::pan(double right, double up) {
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  Vec3 focus;
  camera->GetFocalPoint(focus.data());
  for (int a = 0; a < 3; ++a)
    focus[a] += right * kRight[axis_][a] + up * kUp[axis_][a];
  camera->SetFocalPoint(focus.data());
  showPlane();
}

void SliceView::stepSlices(int count) {
  Vec3 cross = state_->crosshair();
  cross[axis_] += count * state_->stepAlong(axis_);
  state_->setCrosshair(cross);
}

//------------------------------------------------------------------------------
// Mouse and keyboard.

void SliceView::mousePressEvent(QMouseEvent* event) {
  if (button_ != Qt::NoButton || !state_->volume()) return;
  button_ = event->button();
  pressed_ = last_ = event->pos();
  dragging_ = false;
}

void SliceView::mouseMoveEvent(QMouseEvent* event) {
  Q_EMIT pointed(state_->volume() ? state_->describe(toRAS(ui::pointOf(event))) : QString());
  if (button_ == Qt::NoButton) return;
  if (!dragging_ && (event->pos() - pressed_).manhattanLength() < QApplication::startDragDistance()) return;
  dragging_ = true;
  const QPoint by = event->pos() - last_;
  last_ = event->pos();
  if (button_ == Qt::LeftButton && event->modifiers() & Qt::ShiftModifier) {
    state_->setCrosshair(toRAS(ui::pointOf(event)));
  } else if (button_ == Qt::LeftButton) {
    const auto item = state_->volume();
    const double step = (item->range[1] - item->range[0]) / 400;
    const Window& w = *item->window;
    const double level = 0.5 * (w.lower + w.upper) - by.y() * step;
    const double width = std::max(step / 10, w.upper - w.lower + 2 * by.x() * step);
    state_->setWindow(level - 0.5 * width, level + 0.5 * width);
  } else if (button_ == Qt::RightButton) {
    zoom(ui::zoomOfDrag(by.y()));
  } else {
    const double scale = millimetresPerPixel();
    pan(-by.x() * scale, by.y() * scale);
  }
}

void SliceView::mouseReleaseEvent(QMouseEvent* event) {
  if (event->button() != button_) return;
  if (!dragging_ && button_ == Qt::LeftButton) state_->setCrosshair(toRAS(ui::pointOf(event)));
  button_ = Qt::NoButton;
}

void SliceView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton) Q_EMIT doubleClicked();
}

void SliceView::wheelEvent(QWheelEvent* event) {
  event->accept();
  if (event->modifiers() & Qt::ControlModifier)
    zoom(ui::WheelSteps::zoomOf(event));
  else if (const int steps = wheel_.take(event))
    stepSlices(steps);
}

void SliceView::keyPressEvent(QKeyEvent* event) {
  if (const QPointF way = ui::panOfKey(event); !way.isNull()) {
    const double high = millimetresPerPixel() * height();
    if (state_->volume()) pan(way.x() * high, way.y() * high);
    return;
  }
  switch (event->key()) {
  case Qt::Key_Up:
  case Qt::Key_Right:
    stepSlices(1);
    break;
  case Qt::Key_Down:
  case Qt::Key_Left:
    stepSlices(-1);
    break;
  case Qt::Key_PageUp:
    stepSlices(10);
    break;
  case Qt::Key_PageDown:
    stepSlices(-10);
    break;
  case Qt::Key_Plus:
  case Qt::Key_Equal:
  case Qt::Key_Minus:
    zoom(ui::zoomOfKey(event->key()));
    break;
  case Qt::Key_Home:
    fit();
    break;
  default:
    event->ignore();
  }
}

void SliceView::leaveEvent(QEvent*) {
  Q_EMIT pointed(QString());
  pointCrosshair();
}

void SliceView::focusInEvent(QFocusEvent* event) {
  QVTKOpenGLNativeWidget::focusInEvent(event);
  pointCrosshair();
}

void SliceView::focusOutEvent(QFocusEvent* event) {
  QVTKOpenGLNativeWidget::focusOutEvent(event);
  if (!underMouse()) Q_EMIT pointed(QString());
}

void SliceView::pointCrosshair() {
  if (hasFocus() && !underMouse())
    Q_EMIT pointed(state_->volume() ? state_->describe(state_->crosshair()) : QString());
}

} // namespace innergs::app
