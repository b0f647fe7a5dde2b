// The views of the desktop app: linked slices, comparison, 3D.
#include "AppWindowTest.h"

#include "IO/VolumeIO.h"
#include "Widgets/PlaneView.h"

#include <QDoubleSpinBox>
#include <QLabel>
#include <QSlider>
#include <QTimer>
#include <QWheelEvent>

#include <vtkCamera.h>
#include <vtkMatrix4x4.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>

#include <algorithm>
#include <cmath>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;
using innergs::app::MainWindow;
using innergs::app::SliceView;

class AppViewsTest : public AppWindowTest {
  Q_OBJECT
private Q_SLOTS:
  void viewsAreLinked() {
    open({writeBall(*sandbox_, "ball.nii.gz", {40, 40, 20}, {1, 1, 2}, true)});
    app::ViewState* state = window_->state();
    SliceView* axial = window_->views()->slice(2);
    const Vec3 before = state->crosshair();
    const Vec3 target{before[0] + 6, before[1] - 4, before[2]};
    // A click moves the crosshair there; the letters say where right and left are.
    QTest::mouseClick(axial, Qt::LeftButton, {}, axial->fromRAS(target).toPoint());
    QVERIFY(std::abs(state->crosshair()[0] - target[0]) < 0.5 &&
            std::abs(state->crosshair()[1] - target[1]) < 0.5);
    QVERIFY(std::abs(window_->views()->slice(0)->position() - target[0]) < 0.5);
    QCOMPARE(axial->letters()[0], QChar('R'));
    QCOMPARE(axial->letters()[2], QChar('A'));
    QVERIFY(axial->toRAS(QPointF(0, axial->height() / 2))[0] > axial->toRAS(QPointF(axial->width(), 0))[0]);
    QCOMPARE(window_->views()->slice(0)->letters()[0], QChar('A'));
    // The wheel and the keys scroll through the slices by the distance between them.
    const double step = state->stepAlong(2), z = state->crosshair()[2];
    QWheelEvent wheel(QPointF(20, 20), axial->mapToGlobal(QPoint(20, 20)), {}, {0, 120}, Qt::NoButton,
                      Qt::NoModifier, Qt::NoScrollPhase, false);
    QCoreApplication::sendEvent(axial, &wheel);
    QVERIFY(std::abs(state->crosshair()[2] - z - step) < 1e-6);
    QTest::keyClick(axial, Qt::Key_Down);
    QVERIFY(std::abs(state->crosshair()[2] - z) < 1e-6);
    // A drag changes window and level; reset restores them.
    const double lower = state->volume()->window->lower;
    const QPoint at(axial->width() / 2, axial->height() / 2);
    QTest::mousePress(axial, Qt::LeftButton, {}, at);
    QMouseEvent move(QEvent::MouseMove, QPointF(at + QPoint(0, 60)), Qt::LeftButton, Qt::LeftButton, {});
    QCoreApplication::sendEvent(axial, &move);
    QTest::mouseRelease(axial, Qt::LeftButton, {}, at + QPoint(0, 60));
    QVERIFY(state->volume()->window->lower < lower);
    trigger("resetWindow");
    QCOMPARE(state->volume()->window->lower, lower);
    // The value under the mouse.
    QSignalSpy pointed(window_->views(), &app::ViewGrid::pointed);
    QMouseEvent hover(QEvent::MouseMove, axial->fromRAS({0, 0, 0}), Qt::NoButton, Qt::NoButton, {});
    QCoreApplication::sendEvent(axial, &hover);
    QVERIFY2(pointed.last().first().toString().contains(" mm: "),
             qPrintable(pointed.last().first().toString()));
    // A double click enlarges a view, and another restores it.
    QTest::mouseDClick(axial, Qt::LeftButton);
    QVERIFY(!window_->views()->slice(0)->isVisible());
    QTest::mouseDClick(axial, Qt::LeftButton);
    QVERIFY(window_->views()->slice(0)->isVisible());
    // The slider of the view.
    auto* slider = axial->parentWidget()->findChild<QSlider*>("slider");
    QTest::keyClick(slider, Qt::Key_Home);
    QVERIFY(std::abs(axial->position() - state->bounds()[4]) < 1.01 * step);
  }

  void keysMoveWhatIsLookedAt() {
    open({writeBall(*sandbox_, "ball.nii.gz", {40, 40, 20}, {1, 1, 2})});
    app::ViewState* state = window_->state();
    state->setCrosshair({3, -2, 4});
    window_->activateWindow();
    QVERIFY(QTest::qWaitForWindowActive(window_.get()));
    QTest::mouseMove(tree()); // out of the views
    auto* pointed = window_->findChild<QLabel*>("pointed");
    SliceView* axial = window_->views()->slice(2);
    TRY_VERIFY(!axial->underMouse());
    // The value at the crosshair, while a view has the keyboard focus.
    axial->setFocus();
    TRY_VERIFY2(pointed->text().startsWith("R 3.0  P 2.0  S 4.0 mm: ") &&
                    pointed->text().endsWith("scanner units"),
                qPrintable(pointed->text()));
    QTest::keyClick(axial, Qt::Key_Up);
    QVERIFY2(pointed->text().contains("S 6.0 mm"), qPrintable(pointed->text()));
    // Shift and the arrows pan to the patient's left and front; the crosshair stays.
    const auto middle = [&] { return axial->toRAS({0.5 * axial->width(), 0.5 * axial->height()}); };
    const Vec3 before = middle();
    QTest::keyClick(axial, Qt::Key_Right, Qt::ShiftModifier);
    QTest::keyClick(axial, Qt::Key_Up, Qt::ShiftModifier);
    QVERIFY(middle()[0] < before[0] - 0.5 && middle()[1] > before[1] + 0.5);
    QCOMPARE(state->crosshair(), (Vec3{3, -2, 6}));
    QTest::keyClick(axial, Qt::Key_Home);
    QVERIFY(norm(middle() - before) < 1e-6);
    // In 3D as well: there and back.
    auto* space = window_->views()->threeD();
    space->setFocus();
    TRY_VERIFY(pointed->text().isEmpty());
    const QImage still = spaceSeen();
    QTest::keyClick(space, Qt::Key_Left, Qt::ShiftModifier);
    TRY_VERIFY(spaceSeen() != still);
    QTest::keyClick(space, Qt::Key_Home);
    TRY_VERIFY(spaceSeen() == still);
  }

  void comparesVolumesAtTheSamePlace() {
    open(
        {writeBall(*sandbox_, "thick.nii.gz"), writeBall(*sandbox_, "thin.nii.gz", {40, 40, 40}, {1, 1, 1})});
    app::ViewState* state = window_->state();
    QCOMPARE(state->volume()->name, QString("thin"));
    state->setCrosshair({3, -2, 4});
    trigger("nextVolume");
    QCOMPARE(state->volume()->name, QString("thick"));
    QCOMPARE(state->crosshair()[0], 3.0);
    trigger("previousVolume");
    QCOMPARE(state->volume()->name, QString("thin"));
    // By the list as well.
    chooseLine(0);
    QCOMPARE(state->volume()->name, QString("thick"));
  }

  void theVolumeFillsTheSpaceThatItIsSeenIn() {
    open({writeBall(*sandbox_, "ball.nii", {24, 24, 10}, {1.5, 1.5, 4})});
    setQuick();
    app::ThreeDView* space = window_->views()->threeD();
    space->setFocus();
    for (int n = 0; n < 6; ++n)
      QTest::keyClick(space, Qt::Key_Minus);
    QVERIFY(extentSeen() < 0.6);
    reconstruct();
    TRY_VERIFY(extentSeen() > 0.85 && extentSeen() < 1);
    window_->resize(window_->width(), window_->height() - 150);
    TRY_VERIFY(extentSeen() > 0.85 && extentSeen() < 1);
  }

  void rendersVolumesAndEllipsoids() {
    open({writeBall(*sandbox_, "ball.nii.gz", {24, 24, 24}, {1.5, 1.5, 1.5})});
    setQuick();
    reconstruct();
    const QImage planes = spaceSeen();
    trigger("volumeRendering");
    QVERIFY(window_->views()->threeD()->isVolumeRendered());
    TRY_VERIFY(spaceSeen() != planes);
    trigger("volumeRendering");
    trigger("planes");
    const QImage empty = spaceSeen();
    trigger("ellipsoids");
    const auto& model = host().document().models().front();
    QVERIFY(model->ellipsoidsShown);
    TRY_VERIFY(spaceSeen() != empty);
    // It says how many they are.
    QVERIFY(model->ellipsoids > 0 && model->ellipsoids <= model->model->GetNumberOfGaussians());
    QCOMPARE(host().modelInfo(model->id).ellipsoids, model->ellipsoids);
    trigger("ellipsoids");
    TRY_VERIFY(spaceSeen() == empty);
  }

  void queryPlaneIsSeenInSpace() {
    open({writeBall(*sandbox_, "ball.nii.gz", {24, 24, 24}, {1.5, 1.5, 1.5})});
    setQuick();
    reconstruct();
    trigger("planes");
    const auto seen = [this] { return spaceSeen(); };
    const QImage empty = seen();
    window_->showPanel("queryDock");
    TRY_VERIFY(seen() != empty);
    // It follows the panel, including its window and level.
    const QImage axial = seen();
    QTest::mouseClick(window_->findChild<QAbstractButton*>("queryCoronal"), Qt::LeftButton);
    TRY_VERIFY(seen() != axial);
    const auto* plane = window_->findChild<ui::PlaneView*>("queryView");
    const auto* settle = window_->findChild<QTimer*>("settleTimer");
    TRY_VERIFY(!settle->isActive() && plane->image().task.pose == plane->pose());
    const QImage coronal = seen();
    window_->findChild<QDoubleSpinBox*>("queryLevel")->setValue(0);
    TRY_VERIFY(seen() != coronal);
    // Off and on; removed with the model.
    trigger("queryPlane");
    TRY_VERIFY(seen() == empty);
    trigger("queryPlane");
    TRY_VERIFY(seen() != empty);
    window_->showPanel("modelDock"); // it belongs to the panel
    TRY_VERIFY(seen() == empty);
    window_->showPanel("queryDock");
    TRY_VERIFY(seen() != empty);
    host().document().remove(QString(host().document().models().front()->id));
    TRY_VERIFY(seen() == empty);
  }

  void volumesElsewhereAreSeen() {
    Volume far = ball({24, 24, 24}, {1, 1, 1});
    far.geometry.origin[0] += 500;
    const QString file = sandbox_->path("far.nii");
    writeVolume(far, file.toStdString());
    open({writeBall(*sandbox_, "near.nii")});
    SliceView* axial = window_->views()->slice(2);
    axial->stepSlices(1);
    open({file});
    for (int axis = 0; axis < 3; ++axis) {
      SliceView* view = window_->views()->slice(axis);
      const QPointF at = view->fromRAS(window_->state()->crosshair());
      QVERIFY2(view->rect().contains(at.toPoint()),
               qPrintable(QString("%1: %2, %3").arg(axis).arg(at.x()).arg(at.y())));
    }
    const auto besideTheMiddle = [&] {
      const QImage seen = axial->grab().toImage();
      return qGray(seen.pixel(seen.width() / 2 + seen.width() / 20, seen.height() / 2 + seen.height() / 20));
    };
    TRY_VERIFY(besideTheMiddle() > 40);
  }

private:
  /// How far the shown volume's box reaches from the middle of the 3D view to its edge.
  double extentSeen() {
    app::ThreeDView* space = window_->views()->threeD();
    vtkRenderer* renderer = space->renderWindow()->GetRenderers()->GetFirstRenderer();
    const std::array<double, 6> box = window_->state()->bounds();
    vtkMatrix4x4* toView = renderer->GetActiveCamera()->GetCompositeProjectionTransformMatrix(
        double(space->width()) / space->height(), -1, 1);
    double widest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double at[4] = {box[corner & 1], box[2 + (corner >> 1 & 1)], box[4 + (corner >> 2 & 1)], 1};
      toView->MultiplyPoint(at, at);
      widest = std::max({widest, std::abs(at[0] / at[3]), std::abs(at[1] / at[3])});
    }
    return widest;
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppViewsTest>(argc, argv);
}
#include "AppViewsTest.moc"
