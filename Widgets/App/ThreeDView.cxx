#include "Widgets/App/ThreeDView.h"

#include "Widgets/App/Background.h"
#include "Widgets/App/QueryPlane.h"
#include "Widgets/TextFormat.h"
#include "Widgets/ViewGestures.h"

#include <vtkActor.h>
#include <vtkAnnotatedCubeActor.h>
#include <vtkCamera.h>
#include <vtkColorTransferFunction.h>
#include <vtkCoordinate.h>
#include <vtkCubeSource.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkImageProperty.h>
#include <vtkImageResliceMapper.h>
#include <vtkImageSlice.h>
#include <vtkInteractorStyleTrackballCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOrientationMarkerWidget.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPlane.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartVolumeMapper.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace innergs::app {
namespace {

/// VTK's mouse style without its keys (stereo, wireframe, quit), as the view has its own.
class MouseStyle : public vtkInteractorStyleTrackballCamera {
public:
  static MouseStyle* New();
  vtkTypeMacro(MouseStyle, vtkInteractorStyleTrackballCamera);
  void OnChar() override {}
};
vtkStandardNewMacro(MouseStyle);

/// Position, focal point and view angle.
std::array<double, 7> seenFrom(vtkCamera* camera) {
  std::array<double, 7> from;
  camera->GetPosition(from.data());
  camera->GetFocalPoint(from.data() + 3);
  from[6] = camera->GetViewAngle();
  return from;
}

struct Ellipsoids {
  vtkSmartPointer<vtkInnerGSModel> model;
  vtkSmartPointer<vtkActor> actor; // null until they are made
};

} // namespace

struct ThreeDView::Scene {
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkImageResliceMapper> mappers[3];
  vtkNew<vtkPlane> planes[3];
  vtkNew<vtkImageSlice> slices[3];
  vtkNew<vtkCubeSource> box;
  vtkNew<vtkActor> outline;
  vtkNew<vtkSmartVolumeMapper> volumeMapper;
  vtkNew<vtkVolume> volume;
  vtkNew<vtkAnnotatedCubeActor> cube;
  vtkNew<vtkOrientationMarkerWidget> marker;
  vtkNew<vtkTextActor> shown;               // how many ellipsoids
  std::map<QString, Ellipsoids> ellipsoids; // by model ID
};

ThreeDView::ThreeDView(ViewState* state, QWidget* parent)
    : QVTKOpenGLNativeWidget(parent), state_(state), scene_(std::make_unique<Scene>()),
      background_(new Background(this)) {
  setObjectName(QStringLiteral("threeDView"));
  setAccessibleName(tr("3D view"));
  setFocusPolicy(Qt::StrongFocus);
  setToolTip(tr("Drag: turn. Right drag or wheel: zoom. Middle drag: move. Double click: this view alone.\n"
                "Keys: arrows turn, Shift+arrows move, + and − zoom, Home shows all."));
  Scene& s = *scene_;
  s.window->SetMultiSamples(0);
  setRenderWindow(s.window.Get());
  s.window->AddRenderer(s.renderer);
  s.renderer->SetBackground(0.13, 0.14, 0.18);
  s.renderer->SetBackground2(0.36, 0.38, 0.45);
  s.renderer->GradientBackgroundOn();
  vtkNew<MouseStyle> style;
  s.window->GetInteractor()->SetInteractorStyle(style);
  s.window->GetInteractor()->SetDesiredUpdateRate(15);
  for (int a = 0; a < 3; ++a) {
    s.mappers[a]->SliceFacesCameraOff();
    s.mappers[a]->SliceAtFocalPointOff();
    s.mappers[a]->ResampleToScreenPixelsOff();
    s.mappers[a]->SeparateWindowLevelOperationOn();
    s.planes[a]->SetNormal(a == 0, a == 1, a == 2);
    s.mappers[a]->SetSlicePlane(s.planes[a]);
    s.slices[a]->SetMapper(s.mappers[a]);
    s.slices[a]->VisibilityOff();
    s.renderer->AddViewProp(s.slices[a]);
  }
  vtkNew<vtkPolyDataMapper> outline;
  outline->SetInputConnection(s.box->GetOutputPort());
  s.outline->SetMapper(outline);
  s.outline->GetProperty()->SetRepresentationToWireframe();
  s.outline->GetProperty()->LightingOff();
  s.outline->GetProperty()->SetColor(0.8, 0.8, 0.85);
  s.outline->VisibilityOff();
  s.renderer->AddActor(s.outline);
  s.volumeMapper->SetInteractiveUpdateRate(15);
  s.volume->SetMapper(s.volumeMapper);
  s.volume->GetProperty()->ShadeOn();
  s.volume->GetProperty()->SetInterpolationTypeToLinear();
  s.volume->VisibilityOff();
  query_ = std::make_unique<QueryPlane>(s.renderer);
  s.cube->SetXPlusFaceText("R");
  s.cube->SetXMinusFaceText("L");
  s.cube->SetYPlusFaceText("A");
  s.cube->SetYMinusFaceText("P");
  s.cube->SetZPlusFaceText("S");
  s.cube->SetZMinusFaceText("I");
  s.marker->SetOrientationMarker(s.cube);
  s.marker->SetInteractor(s.window->GetInteractor());
  s.marker->SetViewport(0.84, 0, 1, 0.2);
  s.marker->EnabledOn();
  s.marker->InteractiveOff();
  s.shown->GetTextProperty()->SetColor(0.9, 0.9, 0.9);
  s.shown->GetTextProperty()->ShadowOn();
  s.shown->GetPositionCoordinate()->SetCoordinateSystemToNormalizedViewport();
  s.shown->SetPosition(0.01, 0.01);
  s.shown->VisibilityOff();
  s.renderer->AddActor2D(s.shown);
  connect(state, &ViewState::volumeChanged, this, &ThreeDView::showVolume);
  connect(state, &ViewState::windowChanged, this, &ThreeDView::showWindow);
  connect(state, &ViewState::crosshairChanged, this, &ThreeDView::showPlanes);
  connect(state, &ViewState::placeChanged, this, &ThreeDView::fit);
  connect(state->document(), &Document::modelsChanged, this, &ThreeDView::showModels);
  showVolume();
}

ThreeDView::~ThreeDView() {
  scene_->marker->EnabledOff();
}

void ThreeDView::setVolumeRendered(bool on) {
  rendered_ = on;
  showVolume();
}

void ThreeDView::setPlanesShown(bool on) {
  planes_ = on;
  showVolume();
}

void ThreeDView::setQueryPicture(const ui::PlaneImage& picture) {
  query_->setPicture(picture);
  render();
}

void ThreeDView::setQueryWindow(double lower, double upper) {
  query_->setWindow(lower, upper);
  render();
}

void ThreeDView::setQueryShown(bool on) {
  query_->setShown(on);
  render();
}

void ThreeDView::showVolume() {
  Scene& s = *scene_;
  const auto item = state_->volume();
  for (const auto& slice : s.slices)
    slice->SetVisibility(item && planes_);
  s.outline->SetVisibility(item != nullptr);
  s.volume->SetVisibility(item && rendered_);
  if (!item) {
    for (const auto& mapper : s.mappers)
      mapper->RemoveAllInputs();
    s.renderer->RemoveVolume(s.volume);
    s.volumeMapper->RemoveAllInputs();
    fitted_ = false;
    render();
    return;
  }
  for (int a = 0; a < 3; ++a) {
    s.mappers[a]->SetInputData(item->image);
    s.slices[a]->SetUserMatrix(item->ijkToRAS);
  }
  int size[3];
  item->image->GetDimensions(size);
  s.box->SetBounds(-0.5, size[0] - 0.5, -0.5, size[1] - 0.5, -0.5, size[2] - 0.5);
  s.outline->SetUserMatrix(item->ijkToRAS);
  if (rendered_) {
    s.volumeMapper->SetInputData(item->image);
    s.volume->SetUserMatrix(item->ijkToRAS);
    if (!s.renderer->HasViewProp(s.volume)) s.renderer->AddVolume(s.volume);
  }
  showWindow();
  showPlanes();
  if (!std::exchange(fitted_, true)) fit();
}

void ThreeDView::showWindow() {
  Scene& s = *scene_;
  const auto item = state_->volume();
  if (!item) return;
  const double low = item->window->lower, high = item->window->upper, width = high - low;
  for (const auto& slice : s.slices) {
    slice->GetProperty()->SetColorWindow(width);
    slice->GetProperty()->SetColorLevel(0.5 * (low + high));
  }
  if (rendered_) {
    vtkNew<vtkPiecewiseFunction> opacity, edges;
    opacity->AddPoint(low + 0.2 * width, 0);
    opacity->AddPoint(low + 0.55 * width, 0.12);
    opacity->AddPoint(high, 0.5);
    edges->AddPoint(0, 0.2);
    edges->AddPoint(0.15 * width, 1);
    vtkNew<vtkColorTransferFunction> colour;
    colour->AddRGBPoint(low, 0.1, 0.06, 0.05);
    colour->AddRGBPoint(low + 0.4 * width, 0.65, 0.45, 0.35);
    colour->AddRGBPoint(high, 1, 0.97, 0.93);
    s.volume->GetProperty()->SetScalarOpacity(opacity);
    s.volume->GetProperty()->SetGradientOpacity(edges);
    s.volume->GetProperty()->SetColor(colour);
    s.volume->GetProperty()->SetScalarOpacityUnitDistance(2 * state_->stepAlong(0));
  }
  render();
}

void ThreeDView::showPlanes() {
  for (const auto& plane : scene_->planes)
    plane->SetOrigin(state_->crosshair().data());
  render();
}

void ThreeDView::showModels() {
  Scene& s = *scene_;
  for (auto at = s.ellipsoids.begin(); at != s.ellipsoids.end();) {
    const auto item = state_->document()->model(at->first);
    if (item && item->ellipsoidsShown && item->model == at->second.model) {
      ++at;
      continue;
    }
    if (at->second.actor) s.renderer->RemoveActor(at->second.actor);
    at = s.ellipsoids.erase(at);
  }
  QStringList shown;
  for (const auto& item : state_->document()->models()) {
    if (item->ellipsoidsShown && item->ellipsoids > 0)
      shown << ui::shownGaussiansText(item->ellipsoids, item->model->GetNumberOfGaussians());
    if (!item->ellipsoidsShown || s.ellipsoids.contains(item->id)) continue;
    s.ellipsoids[item->id].model = item->model;
    ui::EllipsoidOptions options;
    options.window = item->window;
    background_->run({}, [this, id = item->id, model = item->model, options] {
      QString error;
      vtkSmartPointer<vtkPolyData> centres;
      const QString problem = sentenceOf([&] { centres = ui::ellipsoidCentres(model, options, &error); });
      if (!problem.isEmpty()) error = problem;
      return [this, id, model, options, centres, error] {
        if (!centres)
          Q_EMIT failed(id, error);
        else
          showEllipsoids(id, model, centres, options);
      };
    });
  }
  s.shown->SetInput(shown.join(QLatin1Char('\n')).toUtf8().constData());
  s.shown->GetTextProperty()->SetFontSize(fontInfo().pixelSize() * devicePixelRatio());
  s.shown->SetVisibility(!shown.isEmpty());
  render();
}

void ThreeDView::showEllipsoids(const QString& id, vtkInnerGSModel* model, vtkPolyData* centres,
                                const ui::EllipsoidOptions& options) {
  const auto at = scene_->ellipsoids.find(id);
  if (at == scene_->ellipsoids.end() || at->second.model != model) return; // no longer wanted
  at->second.actor = ui::ellipsoidActor(centres, options);
  scene_->renderer->AddActor(at->second.actor);
  state_->document()->setEllipsoidsDrawn(id, centres->GetNumberOfPoints());
  render();
}

void ThreeDView::fit() {
  const auto item = state_->volume();
  if (!item) return;
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  const std::array<double, 6> box = state_->bounds();
  const double x = (box[0] + box[1]) / 2, y = (box[2] + box[3]) / 2, z = (box[4] + box[5]) / 2;
  camera->SetFocalPoint(x, y, z);
  camera->SetPosition(x - 300, y + 600, z + 250);
  camera->SetViewUp(0, 0, 1);
  frame();
}

void ThreeDView::frame() {
  if (!state_->volume()) return;
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  const std::array<double, 6> box = state_->bounds();
  camera->SetViewAngle(30); // Zoom() below changes it
  scene_->renderer->ResetCamera(box.data());
  // The sphere around the box fits; now moves as close as the box itself allows.
  const double aspect = double(std::max(1, width())) / std::max(1, height());
  vtkMatrix4x4* toView = camera->GetCompositeProjectionTransformMatrix(aspect, -1, 1);
  double widest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    double at[4] = {box[corner & 1], box[2 + (corner >> 1 & 1)], box[4 + (corner >> 2 & 1)], 1};
    toView->MultiplyPoint(at, at);
    widest = std::max({widest, std::abs(at[0] / at[3]), std::abs(at[1] / at[3])});
  }
  constexpr double filled = 0.94; // of the view
  if (widest > 0) camera->Zoom(filled / widest);
  framed_ = seenFrom(camera);
  render();
}

void ThreeDView::resizeEvent(QResizeEvent* event) {
  QVTKOpenGLNativeWidget::resizeEvent(event);
  if (framed_ == seenFrom(scene_->renderer->GetActiveCamera())) frame();
}

void ThreeDView::render() {
  state_->turns().add(this, [this] {
    if (!isVisible()) return;
    scene_->renderer->ResetCameraClippingRange();
    scene_->window->Render();
  });
}

void ThreeDView::pan(double right, double up) {
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  constexpr double half = 3.14159265358979323846 / 360; // radians of half a degree
  const double high = 2 * camera->GetDistance() * std::tan(half * camera->GetViewAngle());
  Vec3 focus, place, normal, above;
  camera->GetFocalPoint(focus.data());
  camera->GetPosition(place.data());
  camera->OrthogonalizeViewUp();
  camera->GetViewUp(above.data());
  camera->GetViewPlaneNormal(normal.data()); // to the eye
  const Vec3 side = cross(above, normal);
  for (int a = 0; a < 3; ++a) {
    const double by = high * (right * side[a] + up * above[a]);
    focus[a] += by;
    place[a] += by;
  }
  camera->SetFocalPoint(focus.data());
  camera->SetPosition(place.data());
  render();
}

void ThreeDView::keyPressEvent(QKeyEvent* event) {
  constexpr double step = 5; // degrees
  vtkCamera* camera = scene_->renderer->GetActiveCamera();
  if (const QPointF way = ui::panOfKey(event); !way.isNull()) {
    pan(way.x(), way.y());
    return;
  }
  switch (event->key()) {
  case Qt::Key_Left:
  case Qt::Key_Right:
    camera->Azimuth(event->key() == Qt::Key_Left ? step : -step);
    break;
  case Qt::Key_Up:
  case Qt::Key_Down:
    camera->Elevation(event->key() == Qt::Key_Up ? -step : step);
    camera->OrthogonalizeViewUp();
    break;
  case Qt::Key_Plus:
  case Qt::Key_Equal:
  case Qt::Key_Minus:
    camera->Dolly(1 / ui::zoomOfKey(event->key()));
    break;
  case Qt::Key_Home:
    fit();
    break;
  default:
    event->ignore();
    return;
  }
  render();
}

void ThreeDView::mouseDoubleClickEvent(QMouseEvent* event) {
  if (event->button() == Qt::LeftButton) Q_EMIT doubleClicked();
}

} // namespace innergs::app
