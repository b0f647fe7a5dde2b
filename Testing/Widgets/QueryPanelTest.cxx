#include "Patience.h"
#include "ShownQueryPanel.h"

#include "Core/Job/ReconstructionJob.h"
#include "vtkInnerGSPointQuery.h"

#include <vtkImageData.h>
#include <vtkPointData.h>
#include <vtkUnsignedCharArray.h>

#include <QApplication>
#include <QCheckBox>
#include <QClipboard>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QImage>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QSignalSpy>
#include <QSlider>
#include <QSurfaceFormat>
#include <QTemporaryDir>
#include <QToolButton>
#include <QtTest>

#include <cmath>

using namespace innergs;
using namespace innergs::ui;

class QueryPanelTest : public QObject {
  Q_OBJECT
  vtkSmartPointer<vtkInnerGSModel> ramp_;

  /// The volume that "Export" creates.
  void exported(Shown& shown) {
    const int before = shown.host.addedVolumes.size();
    QTest::mouseClick(shown.find<QPushButton>("queryExportVolume"), Qt::LeftButton);
    TRY_COMPARE(shown.host.addedVolumes.size(), before + 1);
  }

private Q_SLOTS:
  void initTestCase() { ramp_ = fittedRamp(); }

  void withoutAModelItSaysWhatToDo() {
    Shown shown;
    QVERIFY(!shown.find<QPushButton>("queryExportVolume")->isEnabled());
    QCOMPARE(shown.panel.modelId(), QString());
  }

  void showsTheMiddleOfAModelFirst() {
    Shown shown(ramp_);
    QCOMPARE(shown.panel.modelId(), QString("ramp"));
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), (Vec3{5, -10, 20}));
    QVERIFY(shown.find<QToolButton>("queryAxial")->isChecked());
    QCOMPARE(shown.find<QLabel>("querySize")->text(), QString("20 × 24 pixels"));
    QCOMPARE(shown.view->letters(), (QStringList{"R", "L", "A", "P"}));
    QCOMPARE(shown.find<QDoubleSpinBox>("queryPositionValue")->minimum(), 2.);
    QCOMPARE(shown.find<QDoubleSpinBox>("queryPositionValue")->maximum(), 38.);
  }

  void orientationButtonsAndLetters() {
    Shown shown(ramp_);
    QTest::mouseClick(shown.find<QToolButton>("queryCoronal"), Qt::LeftButton);
    QCOMPARE(shown.view->letters(), (QStringList{"R", "L", "S", "I"}));
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 2), (Vec3{0, 1, 0}));
    QTest::mouseClick(shown.find<QToolButton>("querySagittal"), Qt::LeftButton);
    QCOMPARE(shown.view->letters(), (QStringList{"A", "P", "S", "I"}));
    QVERIFY(shown.find<QToolButton>("querySagittal")->isChecked());
    QVERIFY(!shown.find<QToolButton>("queryCoronal")->isChecked());
  }

  void slidersMoveAndTurnThePlane() {
    Shown shown(ramp_);
    QSignalSpy changed(&shown.panel, &QueryPanel::planeChanged);
    auto* position = shown.find<QSlider>("queryPositionSlider");
    position->setFocus();
    const double before = columnOf(shown.panel.planeToRAS(), 3)[2];
    QTest::keyClick(position, Qt::Key_Right);
    QCOMPARE(changed.size(), 1);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3)[2], before + 2); // a pixel
    auto* box = shown.find<QDoubleSpinBox>("queryPositionValue");
    box->setFocus();
    box->selectAll();
    QTest::keyClicks(box, "12.5");
    QTest::keyClick(box, Qt::Key_Return);
    QVERIFY(std::abs(columnOf(shown.panel.planeToRAS(), 3)[2] - 12.5) < 1e-9);

    auto* tilt = shown.find<QDoubleSpinBox>("queryTiltHorizontalValue");
    tilt->selectAll();
    QTest::keyClicks(tilt, "30");
    QTest::keyClick(tilt, Qt::Key_Return);
    const Vec3 up = columnOf(shown.panel.planeToRAS(), 1);
    QVERIFY(std::abs(up[1] - std::cos(std::acos(-1.) / 6)) < 1e-9 && std::abs(up[2] - 0.5) < 1e-9);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 0), (Vec3{-1, 0, 0}));
    QVERIFY(!shown.find<QToolButton>("queryAxial")->isChecked());
    QCOMPARE(shown.view->letters(), (QStringList{"R", "L", "AS", "PI"}));

    auto* turn = shown.find<QSlider>("queryInPlaneSlider");
    const Vec3 normal = columnOf(shown.panel.planeToRAS(), 2);
    turn->setValue(900);
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 2) - normal) < 1e-9);
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 0) - up) < 1e-9);
  }

  // Numbers that the command line accepts with --ras.
  void copiesThePlaneAsACommand() {
    Shown shown(ramp_);
    QTest::mouseClick(shown.find<QToolButton>("queryCoronal"), Qt::LeftButton);
    shown.find<QDoubleSpinBox>("queryPositionValue")->setValue(-12);
    shown.find<QDoubleSpinBox>("queryPixelSize")->setValue(2);
    QVERIFY(shown.find<QDoubleSpinBox>("queryPositionValue")->text().startsWith("A "));
    QTest::mouseClick(shown.find<QToolButton>("queryCopyCommand"), Qt::LeftButton);
    // Rows to the patient's left and down, through the middle of the model's box around (5, −10, 20).
    const QString command = QGuiApplication::clipboard()->text();
    QVERIFY2(command.contains(" --ras --u -1.000000,0.000000,0.000000 --v 0.000000,0.000000,-1.000000 "
                              "--center 5.000000,-12.000000,20.000000 --size 20,18 --spacing 2 "),
             qPrintable(command));
  }

  void exportedPixelsAreTheModelsValues() {
    Shown shown(ramp_);
    vtkNew<vtkMatrix4x4> plane; // oblique and right-handed
    PlanePose pose;
    pose.orientation = PlaneOrientation::Coronal;
    pose.angles = {25, -15, 40};
    pose.origin = {8, -12, 17};
    toMatrix(pose, plane);
    shown.panel.setPlane(plane);
    shown.find<QDoubleSpinBox>("queryPixelSize")->setValue(1.5);
    exported(shown);
    QVERIFY(shown.host.addedVolumes.last().contains("oblique"));

    vtkImageData* image = shown.host.lastAddedImage;
    vtkMatrix4x4* matrix = shown.host.lastAddedMatrix;
    for (int c = 0; c < 2; ++c)
      QVERIFY(norm(columnOf(matrix, c) - 1.5 * columnOf(plane, c)) < 1e-9);
    QVERIFY(norm(columnOf(matrix, 2) - columnOf(plane, 2)) < 1e-9);
    const Vec3 fromPlane = columnOf(matrix, 3) - pose.origin;
    QVERIFY(std::abs(dot(fromPlane, pose.normal())) < 1e-9);
    int size[3];
    image->GetDimensions(size);
    QCOMPARE(shown.find<QLabel>("querySize")->text(), QString("%1 × %2 pixels").arg(size[0]).arg(size[1]));

    vtkNew<vtkInnerGSPointQuery> truth;
    truth->SetModel(ramp_);
    int inside = 0;
    for (int y = 0; y < size[1]; y += 3)
      for (int x = 0; x < size[0]; x += 3) {
        const double pixel[4] = {double(x), double(y), 0, 1};
        double ras[4];
        matrix->MultiplyPoint(pixel, ras);
        const double value = image->GetScalarComponentAsDouble(x, y, 0, 0);
        QVERIFY(std::abs(value - truth->EvaluatePoint(ras[0], ras[1], ras[2])) < 1e-2);
        if (std::abs(ras[0] - 5) < 12 && std::abs(ras[1] + 10) < 16 && std::abs(ras[2] - 20) < 10) {
          ++inside;
          QVERIFY2(std::abs(value - rampAt(ras[0], ras[1], ras[2])) < 4, qPrintable(QString::number(value)));
        }
      }
    QVERIFY(inside > 20);
  }

  void imageOnTheScreenIsTheModels() {
    Shown shown(ramp_);
    shown.view->setHandlesShown(false);
    const QPoint left = shown.view->widgetAt({-12, 0}).toPoint(),
                 right = shown.view->widgetAt({12, 0}).toPoint();
    const auto grey = [&](const QPoint& p) {
      const QImage image = shown.view->grab().toImage();
      return qGray(image.pixel((QPointF(p) * image.devicePixelRatio()).toPoint()));
    };
    // Left on the screen is the patient's right, where the ramp increases by 3 per millimetre; window 50 to
    // 350.
    const double expected = (rampAt(5 + 12, -10, 20) - 50) / 300 * 255;
    TRY_VERIFY2(std::abs(grey(left) - expected) < 8,
                qPrintable(QString("%1 %2").arg(grey(left)).arg(expected)));
    QVERIFY(std::abs(grey(right) - (rampAt(5 - 12, -10, 20) - 50) / 300 * 255) < 8);
    // Another plane replaces it.
    shown.find<QDoubleSpinBox>("queryPositionValue")->setValue(30);
    TRY_VERIFY(std::abs(grey(left) - (rampAt(17, -10, 30) - 50) / 300 * 255) < 8);
  }

  void theUncertaintyOfThePlaneAndWhatWasNotMeasured() {
    Shown shown(ramp_);
    auto* box = shown.find<QCheckBox>("queryUncertainty");
    QVERIFY(!box->isVisible()); // nothing is known of it
    // 4 mm voxels over the model, 10 towards the patient's left of x = 5 and 30 towards the right; the upper
    // half (y > −10) was not measured.
    auto uncertainty = std::make_shared<UncertaintyVolume>();
    uncertainty->image = vtkSmartPointer<vtkImageData>::New();
    uncertainty->image->SetDimensions(16, 16, 16);
    uncertainty->image->AllocateScalars(VTK_FLOAT, 1);
    vtkNew<vtkUnsignedCharArray> measured;
    measured->SetName("Measured");
    for (int k = 0; k < 16; ++k)
      for (int j = 0; j < 16; ++j)
        for (int i = 0; i < 16; ++i) {
          uncertainty->image->SetScalarComponentFromDouble(i, j, k, 0, i < 8 ? 10 : 30);
          measured->InsertNextValue(j < 8);
        }
    uncertainty->image->GetPointData()->AddArray(measured);
    uncertainty->ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
    const double corner[3] = {5 - 30, -10 - 30, 20 - 30};
    for (int a = 0; a < 3; ++a) {
      uncertainty->ijkToRAS->SetElement(a, a, 4);
      uncertainty->ijkToRAS->SetElement(a, 3, corner[a]);
    }
    uncertainty->usual = 40;
    shown.host.uncertainties["ramp"] = uncertainty;
    Q_EMIT shown.host.modelsChanged();
    QVERIFY(box->isVisible());
    shown.view->setHandlesShown(false);
    const auto pixel = [&](double x, double y) {
      const QImage image = shown.view->grab().toImage();
      return QColor(image.pixel((shown.view->widgetAt({x, y}) * image.devicePixelRatio()).toPoint()));
    };
    const auto isGrey = [](const QColor& c, double of) {
      return std::abs(c.red() - of) < 8 && std::abs(c.blue() - of) < 8;
    };
    TRY_VERIFY(isGrey(pixel(-12, -8), (rampAt(5 + 12, -10 - 8, 20) - 50) / 300 * 255));
    QTest::mouseClick(box, Qt::LeftButton, {}, {5, 5});
    QCOMPARE(shown.find<QDoubleSpinBox>("queryWindow")->value(), 40.0);
    // Left on the screen is the patient's right; black is 0, white 40.
    TRY_VERIFY(isGrey(pixel(-12, -8), 30. / 40 * 255));
    QVERIFY(isGrey(pixel(12, -8), 10. / 40 * 255));
    const QColor unmeasured = pixel(12, 8);
    QVERIFY(unmeasured.red() > unmeasured.blue() + 5); // the stripes and what is between them are orange
    auto* readout = shown.find<QLabel>("queryReadout");
    const QPoint at = shown.view->widgetAt({12, 8}).toPoint();
    QTest::mouseMove(shown.view, at + QPoint(30, 30));
    QTest::mouseMove(shown.view, at);
    TRY_VERIFY2(readout->text().contains(QString::fromUtf8(" ± 10")) &&
                    readout->text().endsWith("scanner units, not measured"),
                qPrintable(readout->text()));
    exported(shown);
    QVERIFY(shown.host.addedVolumes.last().contains("standard deviation"));
    double range[2];
    shown.host.lastAddedImage->GetScalarRange(range);
    QCOMPARE(range[0], 10.0);
    QCOMPARE(range[1], 30.0);
    shown.host.uncertainties.clear(); // the volume was closed
    Q_EMIT shown.host.volumesChanged();
    QVERIFY(!box->isVisible());
    TRY_VERIFY(isGrey(pixel(-12, -8), (rampAt(5 + 12, -10 - 8, 20) - 50) / 300 * 255));
  }

  void valueUnderTheCursor() {
    Shown shown(ramp_);
    auto* readout = shown.find<QLabel>("queryReadout");
    const QPoint at = shown.view->widgetAt({6, -4}).toPoint();
    const QPointF plane = shown.view->planeAt(at);
    QTest::mouseMove(shown.view, at + QPoint(30, 30));
    QTest::mouseMove(shown.view, at);
    const double r = 5 - plane.x(), a = -10 + plane.y();
    const QString place =
        QString("%1, %2, S 20.0 mm: ")
            .arg(positionText({r, a, 0}).section(", ", 0, 0), positionText({0, a, 0}).section(", ", 1, 1));
    TRY_VERIFY2(readout->text().startsWith(place), qPrintable(readout->text() + " not " + place));
    QVERIFY(readout->text().endsWith(" scanner units"));
    const double value = readout->text().section(": ", 1).section(' ', 0, 0).toDouble();
    vtkNew<vtkInnerGSPointQuery> truth;
    truth->SetModel(ramp_);
    QVERIFY(std::abs(value - truth->EvaluatePoint(r, a, 20)) < 0.06);
    QVERIFY(std::abs(value - rampAt(r, a, 20)) < 4);

    QTest::keyClick(shown.view, Qt::Key_PageUp); // the plane moves below the cursor
    TRY_VERIFY2(readout->text().contains("S 22.0 mm"), qPrintable(readout->text()));
    QTest::mouseMove(shown.view, QPoint(2, 2));
    TRY_VERIFY2(readout->text().endsWith("outside the model"), qPrintable(readout->text()));
  }

  void valueInTheMiddleByKeyboard() {
    Shown shown(ramp_);
    auto* readout = shown.find<QLabel>("queryReadout");
    QTest::mouseMove(shown.find<QDoubleSpinBox>("queryLevel")); // out of the view
    TRY_VERIFY(!shown.view->underMouse());
    shown.panel.activateWindow();
    QVERIFY(QTest::qWaitForWindowActive(&shown.panel));
    shown.find<QDoubleSpinBox>("queryPixelSize")->setFocus();
    TRY_VERIFY2(readout->text().startsWith("Wheel"), qPrintable(readout->text()));
    shown.view->setFocus();
    TRY_VERIFY2(readout->text().startsWith("Middle: R 5.0, P 10.0, S 20.0 mm: "),
                qPrintable(readout->text()));
    // Shift and the arrows pan: to the patient's left, and to the front.
    const double step = 0.05 * shown.view->height() * shown.view->scale();
    QTest::keyClick(shown.view, Qt::Key_Right, Qt::ShiftModifier);
    QTest::keyClick(shown.view, Qt::Key_Up, Qt::ShiftModifier);
    const Vec3 at = columnOf(shown.panel.planeToRAS(), 3);
    QVERIFY2(std::abs(at[0] - 5 + step) < 1e-6 && std::abs(at[1] + 10 - step) < 1e-6 &&
                 std::abs(at[2] - 20) < 1e-9,
             qPrintable(QString("%1 %2 %3").arg(at[0]).arg(at[1]).arg(at[2])));
    QVERIFY(shown.find<QToolButton>("queryAxial")->isChecked()); // nothing was tilted
    TRY_VERIFY2(readout->text().startsWith("Middle: " + positionText(at)), qPrintable(readout->text()));
    const double value = readout->text().section(": ", 2).section(' ', 0, 0).toDouble();
    QVERIFY2(std::abs(value - rampAt(at[0], at[1], at[2])) < 4, qPrintable(readout->text()));
    QTest::keyClick(shown.view, Qt::Key_Left, Qt::ShiftModifier);
    QTest::keyClick(shown.view, Qt::Key_Down, Qt::ShiftModifier);
    QVERIFY(norm(columnOf(shown.panel.planeToRAS(), 3) - Vec3{5, -10, 20}) < 1e-6);
    shown.find<QDoubleSpinBox>("queryPixelSize")->setFocus();
    TRY_VERIFY2(readout->text().startsWith("Wheel"), qPrintable(readout->text()));
  }

  void linkedPlaneStaysWhereAResultArrives() {
    Shown shown(ramp_);
    vtkNew<vtkMatrix4x4> plane;
    toMatrix({PlaneOrientation::Axial, false, {}, {5, -10, 200}}, plane); // above the model
    shown.panel.setPlane(plane);
    QSignalSpy changed(&shown.panel, &QueryPanel::planeChanged);
    const QString ball = shown.host.addBallModel();
    shown.panel.setModelId(ball);
    QCOMPARE(changed.size(), 0);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), (Vec3{5, -10, 200}));
    QVERIFY2(shown.view->note().contains("beside the model"), qPrintable(shown.view->note()));
    // The same model replaced, and after the plane was moved in the panel.
    QTest::keyClick(shown.view, Qt::Key_PageUp);
    const Vec3 moved = columnOf(shown.panel.planeToRAS(), 3);
    QVERIFY(moved[2] > 200);
    const int count = changed.size();
    shown.panel.setModelId("ramp");
    QCOMPARE(changed.size(), count);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), moved);
    // The button brings it back.
    QTest::mouseClick(shown.find<QPushButton>("queryCentre"), Qt::LeftButton);
    QCOMPARE(columnOf(shown.panel.planeToRAS(), 3), (Vec3{5, -10, 20}));
    QCOMPARE(shown.view->note(), QString());
  }

  void everythingIsReachedByKeyboard() {
    Shown shown(ramp_);
    QStringList order;
    for (QWidget* w = shown.panel.nextInFocusChain(); w != &shown.panel; w = w->nextInFocusChain())
      if (shown.panel.isAncestorOf(w) && (w->focusPolicy() & Qt::TabFocus) && w->isEnabled() &&
          !w->objectName().isEmpty() && !w->objectName().startsWith("qt_"))
        order << w->objectName();
    const QStringList wanted{"queryAxial",
                             "queryCoronal",
                             "querySagittal",
                             "queryCentre",
                             "queryPositionSlider",
                             "queryPositionValue",
                             "queryTiltHorizontalSlider",
                             "queryTiltHorizontalValue",
                             "queryTiltVerticalSlider",
                             "queryTiltVerticalValue",
                             "queryInPlaneSlider",
                             "queryInPlaneValue",
                             "queryPixelSize",
                             "queryView",
                             "queryCopyCommand",
                             "queryWindow",
                             "queryLevel",
                             "queryAutoWindow",
                             "queryUncertainty",
                             "queryHandles",
                             "queryExportVolume",
                             "querySavePicture"};
    QCOMPARE(order.mid(order.indexOf("queryAxial")), wanted);
  }

  void planeFromOutside() {
    Shown shown(ramp_);
    QSignalSpy changed(&shown.panel, &QueryPanel::planeChanged);
    vtkNew<vtkMatrix4x4> plane; // like a sagittal slice node's, including its pixel size
    toMatrix({PlaneOrientation::Sagittal, false, {}, {1, 2, 3}}, plane);
    for (int r = 0; r < 3; ++r)
      plane->SetElement(r, 0, 0.7 * plane->GetElement(r, 0));
    shown.panel.setPlane(plane);
    QCOMPARE(changed.size(), 1);
    QVERIFY(shown.find<QToolButton>("querySagittal")->isChecked());
    QCOMPARE(shown.find<QDoubleSpinBox>("queryPositionValue")->value(), -1.);
    shown.panel.setPlane(shown.panel.planeToRAS()); // causes no endless loop
    QCOMPARE(changed.size(), 1);

    plane->Zero();
    shown.panel.setPlane(plane);
    QCOMPARE(changed.size(), 1);
    QVERIFY2(shown.message().contains("must be finite and span a plane"), qPrintable(shown.message()));
  }

  void pictureHasTheWindowAndThePlace() {
    QTemporaryDir folder;
    Shown shown(ramp_);
    shown.host.setFolder(folder.path());
    QTest::mouseClick(shown.find<QPushButton>("querySavePicture"), Qt::LeftButton);
    QFileDialog* dialog = nullptr;
    TRY_VERIFY((dialog = shown.find<QFileDialog>("queryPictureDialog")));
    QCOMPARE(dialog->directory().absolutePath(), QDir(folder.path()).absolutePath());
    const QString file = folder.filePath("plane.png");
    Q_EMIT dialog->fileSelected(file);
    dialog->reject();
    TRY_VERIFY(shown.message().contains("plane.png"));
    const QImage picture(file);
    QCOMPARE(picture.size(), QSize(20, 24));
    QCOMPARE(picture.dotsPerMeterX(), 500);
    QVERIFY(picture.text("PixelToRAS").startsWith("-2 0 0 24"));
    // The top left corner is the patient's right and front, the bottom left one right and back.
    const auto expected = [](double r, double a) {
      return std::clamp((rampAt(r, a, 20) - 50) / 300 * 255, 0., 255.);
    };
    QVERIFY(std::abs(qGray(picture.pixel(3, 3)) - expected(18, 7)) < 6);
    QVERIFY(std::abs(qGray(picture.pixel(3, 20)) - expected(18, -27)) < 6);

    QTest::mouseClick(shown.find<QPushButton>("querySavePicture"), Qt::LeftButton);
    TRY_VERIFY((dialog = shown.find<QFileDialog>("queryPictureDialog")));
    Q_EMIT dialog->fileSelected(folder.filePath("missing/plane.png"));
    dialog->reject();
    TRY_VERIFY(shown.message().contains("choose another folder or name"));
  }

  void errorsAreSentencesInThePanel() {
    Shown shown(ramp_);
    shown.host.modelError = "The disk is full: free some space.";
    QTest::mouseClick(shown.find<QPushButton>("queryExportVolume"), Qt::LeftButton);
    TRY_VERIFY(shown.message().contains(shown.host.modelError));
    shown.host.modelError.clear();
    vtkNew<vtkInnerGSModel> huge; // 36 m wide
    auto core = std::make_shared<Model>(*ramp_->GetCoreModel());
    core->field.domain.spacing = {2000, 2000, 2000};
    huge->SetCoreModel(core);
    addModel(shown.host, "huge", huge, {0, 1});
    shown.panel.setModelId("huge");
    QTest::mouseClick(shown.find<QPushButton>("queryExportVolume"), Qt::LeftButton);
    TRY_VERIFY2(shown.message().contains("choose a larger pixel size"), qPrintable(shown.message()));
    QVERIFY(shown.host.addedVolumes.isEmpty());
  }

  void modelsComeAndGo() {
    Shown shown(ramp_);
    QSignalSpy changed(&shown.panel, &QueryPanel::modelIdChanged);
    shown.host.models.remove("ramp");
    shown.host.modelData.remove("ramp");
    Q_EMIT shown.host.modelsChanged();
    TRY_COMPARE(shown.panel.modelId(), QString());
    QVERIFY(!shown.find<QPushButton>("queryExportVolume")->isEnabled());
    const QString ball = shown.host.addBallModel();
    shown.panel.setModelId(ball);
    QCOMPARE(shown.panel.modelId(), ball);
    QCOMPARE(changed.size(), 2);
    QVERIFY(shown.find<QPushButton>("queryExportVolume")->isEnabled());
    exported(shown);
    vtkNew<vtkInnerGSPointQuery> truth;
    truth->SetModel(shown.host.modelData[ball]);
    int size[3];
    shown.host.lastAddedImage->GetDimensions(size);
    const double middle[4] = {double(size[0] / 2), double(size[1] / 2), 0, 1};
    double ras[4];
    shown.host.lastAddedMatrix->MultiplyPoint(middle, ras);
    const double value =
        shown.host.lastAddedImage->GetScalarComponentAsDouble(size[0] / 2, size[1] / 2, 0, 0);
    QVERIFY(value > 20);
    QVERIFY(std::abs(value - truth->EvaluatePoint(ras[0], ras[1], ras[2])) < 0.01);
  }

  void deletedWhileQuerying() {
    for (int i = 0; i < 5; ++i) {
      Shown shown(ramp_);
      shown.find<QDoubleSpinBox>("queryPixelSize")->setValue(0.05);
      for (int turn = 0; turn < 2 * i; ++turn) // turns of the event loop
        QCoreApplication::processEvents();
    }
  }
};

int main(int argc, char** argv) {
  qRegisterMetaType<vtkMatrix4x4*>("vtkMatrix4x4*");
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QLocale::setDefault(QLocale::c());
  QApplication app(argc, argv);
  QueryPanelTest test;
  return QTest::qExec(&test, argc, argv);
}
#include "QueryPanelTest.moc"
