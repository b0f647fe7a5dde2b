#include "Patience.h"
#include "ShownQueryPanel.h"

#include "Core/Job/ReconstructionJob.h"

#include <QDoubleSpinBox>
#include <QPushButton>
#include <QSignalSpy>
#include <QSlider>
#include <QSurfaceFormat>
#include <QTimer>
#include <QToolButton>
#include <QWheelEvent>

#include <cmath>
#include <random>

using namespace innergs;
using namespace innergs::ui;

namespace {

/// A model with as many Gaussians as a fit of minutes would have.
vtkSmartPointer<vtkInnerGSModel> largeModel(int count, float sigma = 1.2f) {
  auto core = std::make_shared<Model>();
  auto& field = core->field;
  field.intensityScale = 1000;
  field.domain.size = {180, 216, 180};
  field.domain.origin = {-89.5, -107.5, -89.5};
  std::mt19937 random(1);
  std::uniform_real_distribution<float> one(-1, 1);
  for (int i = 0; i < count; ++i) {
    Gaussian g{};
    g.mean[0] = 90 * one(random), g.mean[1] = 108 * one(random), g.mean[2] = 90 * one(random);
    for (int a = 0; a < 3; ++a) {
      g.logScale[a] = std::log(sigma) + 0.3f * one(random);
      g.quaternion[a] = one(random);
    }
    g.quaternion[3] = 1.1f;
    g.intensity = 0.5f + 0.5f * one(random);
    field.gaussians.push_back(g);
  }
  auto model = vtkSmartPointer<vtkInnerGSModel>::New();
  model->SetCoreModel(core);
  return model;
}

} // namespace

class QueryDragTest : public QObject {
  Q_OBJECT
  vtkSmartPointer<vtkInnerGSModel> ramp_;

private Q_SLOTS:
  void initTestCase() { ramp_ = fittedRamp(); }

  void handlesTiltTurnAndMove() {
    Shown shown(ramp_);
    PlaneView* view = shown.view;
    const QPoint middle = view->rect().center();
    const int radius = static_cast<int>(view->handles().radius());
    QVERIFY(view->handles().fit());
    QSignalSpy changed(&shown.panel, &QueryPanel::planeChanged);

    QTest::mouseMove(view, middle + QPoint(radius, 0));
    TRY_COMPARE(view->cursor().shape(), Qt::SizeHorCursor);
    const Vec3 up = columnOf(shown.panel.planeToRAS(), 1);
    drag(view, middle + QPoint(radius, 0), middle + QPoint(radius - 30, 0));
    QVERIFY(changed.size() > 0);
    const double angle = 30. / view->handles().radius() * 180 / std::acos(-1.);
    const double tilted = std::acos(columnOf(shown.panel.planeToRAS(), 2)[2]) * 180 / std::acos(-1.);
    QVERIFY2(std::abs(tilted - angle) < 0.1, qPrintable(QString("%1 %2").arg(tilted).arg(angle)));
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 1) - up) < 1e-9); // about the vertical axis
    QVERIFY(std::abs(std::abs(shown.find<QDoubleSpinBox>("queryTiltVerticalValue")->value()) - angle) < 0.1);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), (Vec3{5, -10, 20})); // around the centre

    QTest::mouseClick(shown.find<QToolButton>("queryAxial"), Qt::LeftButton);
    const Vec3 right = columnOf(shown.panel.planeToRAS(), 0);
    drag(view, middle + QPoint(0, -radius), middle + QPoint(0, -radius - 20));
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 0) - right) < 1e-9);
    QVERIFY(std::abs(std::abs(shown.find<QDoubleSpinBox>("queryTiltHorizontalValue")->value()) -
                     angle * 2 / 3) < 0.1);

    QTest::mouseClick(shown.find<QToolButton>("queryAxial"), Qt::LeftButton);
    const Vec3 normal = columnOf(shown.panel.planeToRAS(), 2);
    const int part = static_cast<int>(radius * std::sqrt(0.5));
    drag(view, middle + QPoint(part, -part), middle + QPoint(-part, -part)); // a quarter, counter-clockwise
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 2) - normal) < 1e-9);
    // What was on the right (L) is now at the top.
    QVERIFY(std::abs(shown.find<QDoubleSpinBox>("queryInPlaneValue")->value() + 90) < 2);
    QCOMPARE(view->letters(), (QStringList{"A", "P", "L", "R"}));

    drag(view, middle, middle - QPoint(0, 10));
    QVERIFY(std::abs(columnOf(shown.panel.planeToRAS(), 3)[2] - 20 - 10 * view->scale()) < 1e-6);
  }

  void nearSideFollowsTheMouseWhateverTheHandedness() {
    for (const bool reversed : {false, true}) {
      Shown shown(ramp_);
      PlaneView* view = shown.view;
      PlanePose pose;
      pose.reversed = reversed;
      pose.origin = {5, -10, 20};
      vtkNew<vtkMatrix4x4> matrix;
      toMatrix(pose, matrix);
      shown.panel.setPlane(matrix);
      // Towards the viewer: the cross product of right and up on the screen.
      const Vec3 viewer = cross(columnOf(matrix, 0), columnOf(matrix, 1));
      const QPoint grip = view->rect().center() + QPoint(static_cast<int>(view->handles().radius()), 0);
      drag(view, grip, grip - QPoint(40, 0)); // to the left
      // A point in front of the plane has moved to the left.
      QVERIFY(dot(viewer, columnOf(shown.panel.planeToRAS(), 0)) < -0.05);
    }
  }

  void wheelPanZoomAndKeys() {
    Shown shown(ramp_);
    PlaneView* view = shown.view;
    const QPointF middle = view->rect().center();
    const auto wheel = [&](int delta, Qt::KeyboardModifiers keys) {
      QWheelEvent event(middle, view->mapToGlobal(middle.toPoint()), {}, {0, delta}, Qt::NoButton, keys,
                        Qt::NoScrollPhase, false);
      QApplication::sendEvent(view, &event);
    };
    wheel(120, Qt::NoModifier);
    QVERIFY(std::abs(columnOf(shown.panel.planeToRAS(), 3)[2] - 22) < 1e-9); // by a pixel
    const double scale = view->scale();
    wheel(120, Qt::ControlModifier);
    QVERIFY(view->scale() < 0.9 * scale);
    const double nearer = view->scale();
    drag(view, {60, 60}, {60, 100}, Qt::RightButton);
    QVERIFY(view->scale() > 1.1 * nearer);
    const Vec3 before = columnOf(shown.panel.planeToRAS(), 3);
    drag(view, {60, 60}, {80, 60},
         Qt::MiddleButton); // the picture moves right: the centre moves left, to the patient's right
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 3) - before - Vec3{20 * view->scale(), 0, 0}) < 1e-6);
    QTest::keyClick(view, Qt::Key_PageDown);
    QVERIFY(std::abs(columnOf(shown.panel.planeToRAS(), 3)[2] - 20) < 1e-9);
    QTest::keyClick(view, Qt::Key_Right, Qt::ControlModifier);
    QVERIFY(std::abs(shown.find<QDoubleSpinBox>("queryInPlaneValue")->value() - 1) < 1e-9);
    QTest::keyClick(view, Qt::Key_Home);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), (Vec3{5, -10, 20}));
    QVERIFY(std::abs(view->scale() - scale) < 0.2 * scale);
  }

  void slowPlanesAreCoarserWhileTheyMove() {
    Shown shown(largeModel(100000, 5), {0, 1000});
    PlaneView* view = shown.view;
    auto* pixelSize = shown.find<QDoubleSpinBox>("queryPixelSize");
    pixelSize->setValue(0.25); // 720 × 864 pixels
    TRY_VERIFY(view->image().image && view->image().task.pixelSize == 0.25);
    if (view->image().milliseconds < 20) QSKIP("This machine computes the plane in time.");
    const QPoint middle = view->rect().center();
    QTest::mousePress(view, Qt::LeftButton, {}, middle);
    QMouseEvent move(QEvent::MouseMove, middle - QPoint(0, 9), view->mapToGlobal(middle - QPoint(0, 9)),
                     Qt::NoButton, Qt::LeftButton, Qt::NoModifier);
    QApplication::sendEvent(view, &move);
    TRY_VERIFY(view->image().task.pose == view->pose());
    QVERIFY(view->image().task.pixelSize >= 0.5);
    TRY_VERIFY(!shown.find<QTimer>("settleTimer")->isActive());
    QVERIFY(view->image().task.pixelSize >= 0.5); // as long as the button is held
    QTest::mouseRelease(view, Qt::LeftButton, {}, middle - QPoint(0, 9));
    TRY_COMPARE(view->image().task.pixelSize, 0.25);
    QVERIFY(view->image().task.pose == view->pose());
    QTest::keyClick(view, Qt::Key_PageUp); // without a release
    TRY_VERIFY(view->image().task.pose == view->pose() && view->image().task.pixelSize == 0.25);
  }

  void wheelPassesWhatHasNoFocus() {
    Shown shown(ramp_);
    auto* slider = shown.find<QSlider>("queryPositionSlider");
    shown.view->setFocus();
    const double before = columnOf(shown.panel.planeToRAS(), 3)[2];
    const QPointF at = slider->rect().center();
    QWheelEvent event(at, slider->mapToGlobal(at.toPoint()), {}, {0, 120}, Qt::NoButton, Qt::NoModifier,
                      Qt::NoScrollPhase, false);
    QApplication::sendEvent(slider, &event);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3)[2], before);
  }

  void windowAndLevelByDrag() {
    Shown shown(ramp_);
    QCOMPARE(shown.find<QDoubleSpinBox>("queryWindow")->value(), 300.);
    QCOMPARE(shown.find<QDoubleSpinBox>("queryLevel")->value(), 200.);
    drag(shown.view, {40, 60}, {90, 60});
    QVERIFY(shown.find<QDoubleSpinBox>("queryWindow")->value() > 330);
    drag(shown.view, {40, 60}, {40, 40});
    QVERIFY(shown.find<QDoubleSpinBox>("queryLevel")->value() > 210);
    shown.find<QDoubleSpinBox>("queryWindow")->setValue(100);
    QVERIFY(std::abs(shown.view->upper() - shown.view->lower() - 100) < 1e-9);
    QTest::mouseClick(shown.find<QPushButton>("queryAutoWindow"), Qt::LeftButton);
    QCOMPARE(shown.view->lower(), 50.);
    QCOMPARE(shown.view->upper(), 350.);
  }

  void largeModelFollowsADragWithoutHoldingTheLoop() {
    Shown shown(largeModel(300000), {0, 1000});
    shown.find<QDoubleSpinBox>("queryPixelSize")->setValue(0.5);
    PlaneView* view = shown.view;
    const auto inFull = [&] {
      return view->image().image && view->image().task.pose == view->pose() &&
             view->image().task.pixelSize == 0.5;
    };
    TRY_VERIFY(inFull());
    const QPoint middle = view->rect().center();
    const int radius = static_cast<int>(view->handles().radius());
    QTest::mousePress(view, Qt::LeftButton, {}, middle + QPoint(radius, 0));
    for (int step = 1; step <= 20; ++step) {
      const PlaneImage before = view->image();
      const QPoint at = middle + QPoint(radius - 6 * step, 0);
      QMouseEvent move(QEvent::MouseMove, at, view->mapToGlobal(at), Qt::NoButton, Qt::LeftButton,
                       Qt::NoModifier);
      QApplication::sendEvent(view, &move);
      QVERIFY(view->image().image == before.image); // it is computed on another thread
      TRY_VERIFY(view->image().image != before.image);
    }
    QTest::mouseRelease(view, Qt::LeftButton, {}, middle + QPoint(radius - 120, 0));
    TRY_VERIFY(inFull());
  }
};

int main(int argc, char** argv) {
  qRegisterMetaType<vtkMatrix4x4*>("vtkMatrix4x4*");
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QLocale::setDefault(QLocale::c());
  QApplication app(argc, argv);
  QueryDragTest test;
  return QTest::qExec(&test, argc, argv);
}
#include "QueryDragTest.moc"
