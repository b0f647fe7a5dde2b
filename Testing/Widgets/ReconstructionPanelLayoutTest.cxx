#include "ReconstructionPanelFixture.h"
#include "Widgets/FitChart.h"
#include "Widgets/PreviewView.h"
#include "Widgets/Section.h"
#include "Widgets/SlicesDialog.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QHeaderView>
#include <QKeySequence>
#include <QTableView>
#include <QToolButton>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>

using namespace innergs::ui;
using innergs::Phase;

/// Keyboard, widths, scales and colours.
class ReconstructionPanelLayoutTest : public ReconstructionPanelFixture {
  Q_OBJECT

private Q_SLOTS:
  void onlyWhatTheHostOffersIsShown() {
    QVERIFY(child<Selector>("maskSelector") && child<Selector>("regionSelector"));
    make({Host::Role::Input});
    QVERIFY(!child<Selector>("maskSelector") && !child<Selector>("regionSelector"));
    QVERIFY(!child<Selector>("referenceSelector") && !child<Selector>("outputVolumeSelector"));
    QCOMPARE(child<QComboBox>("outputGrid")->count(), 3);
  }

  void otherAxesAreDescribed() {
    choose("head");
    auto* axis = child<QComboBox>("sliceAxis");
    axis->setFocus();
    QTest::keyClick(axis, Qt::Key_Down); // I
    QCOMPARE(panel_->request().inputs[0].sliceAxis, 0);
    QVERIFY(label("inputDescription").startsWith("256 slices along I"));
    QCOMPARE(child<QDoubleSpinBox>("sliceThickness")->text(), QString("auto (0.9 mm)"));
  }

  /// Everything by Tab, arrows and Space; the button keeps the focus from start to end.
  void keyboardAlone() {
    auto* first = rows()[0]->findChild<Selector*>()->findChild<QComboBox*>();
    first->setFocus();
    QTest::keyClick(first, Qt::Key_Down);
    QCOMPARE(panel_->request().inputs.size(), 1);
    TRY_VERIFY(button()->isEnabled());
    QStringList order;
    for (int i = 0; i < 60 && QApplication::focusWidget() != button(); ++i) {
      QWidget* at = QApplication::focusWidget();
      QVERIFY(at && panel_->isAncestorOf(at));
      QWidget* named = at;
      while (named->objectName().isEmpty() || named->objectName().startsWith("qt_"))
        named = named->parentWidget();
      order << named->objectName();
      QTest::keyClick(at, Qt::Key_Tab);
    }
    QCOMPARE(QApplication::focusWidget(), button());
    const QStringList expected{"inputSelector",
                               "sliceThickness",
                               "sliceProfile",
                               "sliceAxis",
                               "addInput",
                               "maskSelector",
                               "regionSelector",
                               "outputGrid",
                               "outputVolumeSelector",
                               "preset",
                               "device",
                               "evaluateQuality",
                               "estimateUncertainty",
                               "sectionButton"};
    QVERIFY2(order == expected, qPrintable(order.join(' ')));
    QTest::keyClick(button(), Qt::Key_Space);
    QVERIFY(host_->isRunning());
    QCOMPARE(QApplication::focusWidget(), button());
    QTest::keyClick(QApplication::focusWidget(), Qt::Key_Space);
    QCOMPARE(host_->cancels, 1);
    TRY_COMPARE(button()->text(), QString("&Reconstruct"));
    QCOMPARE(QApplication::focusWidget(), button());
    QTest::keyClick(QApplication::focusWidget(), Qt::Key_Space);
    QCOMPARE(host_->requests.size(), 2);
  }

  void everyAltKeyGoesToOnePlace() {
    panel_->findChild<Section*>("advanced")->setOpen(true);
    QMap<QString, QString> places;
    for (const auto* widget : panel_->findChildren<QWidget*>()) {
      const auto* text = qobject_cast<const QLabel*>(widget);
      const auto* pressed = qobject_cast<const QAbstractButton*>(widget);
      if (!(text && text->buddy()) && !pressed) continue;
      const QString words = text ? text->text() : pressed->text();
      const QString key = QKeySequence::mnemonic(words).toString();
      if (key.isEmpty()) continue;
      QVERIFY2(!places.contains(key), qPrintable(key + ": " + places[key] + ", " + words));
      places[key] = words;
    }
    QVERIFY(places.size() >= 12);
    for (auto* field : panel_->findChildren<QWidget*>()) // and every field has a description
      if (qobject_cast<QComboBox*>(field) || qobject_cast<QAbstractSpinBox*>(field) ||
          qobject_cast<QCheckBox*>(field)) {
        auto* parent = qobject_cast<Selector*>(field->parentWidget());
        QVERIFY2(!(parent ? parent : field)->toolTip().isEmpty(), qPrintable(field->objectName()));
      }
  }

  void tabVisitsTheScansInOrder() {
    Request request;
    request.inputs = {{"head", 0, 1, -1}, {"side", 0, 1, -1}, {"thin", 0, 1, -1}};
    panel_->setRequest(request);
    QTest::mouseClick(rows()[1]->findChild<QToolButton*>("removeInput"), Qt::LeftButton);
    QTest::mouseClick(child<QToolButton>("addInput"), Qt::LeftButton);
    QCOMPARE(rows().size(), 3);
    QWidget* last = QApplication::focusWidget(); // the new row's
    QVERIFY(rows()[2]->isAncestorOf(last));
    rows()[0]->fields().first()->setFocus();
    QStringList order;
    while (QApplication::focusWidget() != child<QToolButton>("addInput") && order.size() < 20) {
      QWidget* at = QApplication::focusWidget();
      for (int r = 0; r < 3; ++r)
        if (rows()[r]->isAncestorOf(at)) order << QString::number(r);
      QTest::keyClick(at, Qt::Key_Tab);
    }
    QCOMPARE(order.join(""), QString("000000111111222222"));
    QTest::keyClick(QApplication::focusWidget(), Qt::Key_Tab); // and goes on below
    QVERIFY(child<Selector>("maskSelector")->isAncestorOf(QApplication::focusWidget()));
  }

  /// In every state, 400 pixels wide; the test also runs at 150 %.
  void nothingIsClipped() {
    panel_->findChild<Section*>("advanced")->setOpen(true);
    Request request;
    request.inputs = {{"head", 0, 1, -1}, {"side", 0, 2, 0}};
    request.grid = OutputGrid::Spacing;
    panel_->setRequest(request);
    TRY_VERIFY(button()->isEnabled());
    checkFit("panel-advanced");
    const QSize usual = area_->size();
    area_->resize(panel_->minimumSizeHint().width() + area_->width() - area_->viewport()->width(), 700);
    checkFit("panel-narrow");
    area_->resize(usual);
    QTest::mouseClick(button(), Qt::LeftButton);
    for (int i = 1; i < 30; ++i)
      host_->sendProgress(Phase::Fitting, i / 30.0, 3 * i, 0.02 * std::exp(-0.1 * i), 20 + 0.5 * i, 4000,
                          i == 1 ? "On the CPU. The CUDA backend is not installed." : "");
    host_->sendPreview();
    TRY_VERIFY(label("phaseText").contains("87"));
    checkFit("panel-advanced-running");
    showSlices("slices-dialog");
    checkFit("panel-advanced-finished");
    host_->sendFailed("The file cannot be read: choose another one, or export it again from the scanner");
    checkFit("panel-advanced-error");
  }

  void coloursFollowADarkPalette() {
    const QPalette before = QApplication::palette();
    QPalette dark(QColor(53, 53, 53));
    dark.setColor(QPalette::Base, QColor(30, 30, 30));
    for (const auto role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText})
      dark.setColor(QPalette::Disabled, role, QColor(128, 128, 128));
    QApplication::setPalette(dark);
    start();
    for (int i = 1; i < 30; ++i)
      host_->sendProgress(Phase::Fitting, i / 30.0, 3 * i, 0.02 * std::exp(-0.1 * i), 20 + 0.5 * i, 40);
    host_->sendPreview();
    TRY_VERIFY(label("phaseText").contains("87"));
    snapshot(*panel_, "panel-dark-running");
    const QImage chart = child<FitChart>("fitChart")->grab().toImage();
    QVERIFY(qGray(chart.pixel(2, 2)) < 60);
    QVERIFY(brightest(chart) > 150); // its text
    QVERIFY(qGray(label_("phaseText")->grab().toImage().pixel(0, 0)) < 90);
    showSlices("slices-dialog-dark");
    snapshot(*panel_, "panel-dark-finished");
    QVERIFY(label("fitNumbers").contains(dark.color(QPalette::Text).name())); // the legend's line
    QApplication::setPalette(before);
    TRY_VERIFY(label("fitNumbers").contains(before.color(QPalette::Text).name()));
  }

  void previewShowsPatientSides() {
    PreviewView view;
    vtkNew<vtkImageData> image;
    image->SetDimensions(8, 6, 4);
    image->AllocateScalars(VTK_SHORT, 1);
    for (int k = 0; k < 4; ++k)
      for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 8; ++i) // bright: patient's right, front, top
          image->SetScalarComponentFromDouble(i, j, k, 0, i >= 4 && j >= 3 ? 100 : k >= 3 ? 50 : 0);
    vtkNew<vtkMatrix4x4> matrix;
    view.setImage(image, matrix);
    view.resize(400, view.heightForWidth(400));
    const QImage seen = view.grab().toImage();
    const double mm = (400 - 8) / (8.0 + 8 + 6); // pixels per mm
    const auto at = [&](double x, double y) {
      return qGray(seen.pixel((QPointF(x, y) * seen.devicePixelRatio()).toPoint()));
    };
    // axial: x grows to the patient's left, so +R is on the left; up is the front
    QVERIFY(at(1 * mm, 1 * mm) > 200);
    QVERIFY(at(7 * mm, 5 * mm) < 50);
    QVERIFY(at(7 * mm, 1 * mm) < 50);
    matrix->SetElement(0, 0, -1); // i runs to the left: mirrored
    view.setImage(image, matrix);
    const QImage mirrored = view.grab().toImage();
    QVERIFY(qGray(mirrored.pixel((QPointF(7 * mm, 1 * mm) * mirrored.devicePixelRatio()).toPoint())) > 200);
    view.setImage(nullptr, nullptr);
    QVERIFY(view.isEmpty());
  }

private:
  QLabel* label_(const char* name) { return child<QLabel>(name); }
  static int brightest(const QImage& image) {
    int most = 0;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        most = std::max(most, qGray(image.pixel(x, y)));
    return most;
  }
  /// Of a result that has moved slices.
  void showSlices(const QString& name) {
    host_->result = true;
    host_->slices = FakeHost::exampleSlices();
    host_->sendFinished(FakeHost::exampleReport());
    QTest::mouseClick(child<QPushButton>("createSliceTransforms"), Qt::LeftButton);
    QTest::mouseClick(child<QPushButton>("showSlices"), Qt::LeftButton);
    auto* dialog = child<SlicesDialog>("slicesDialog");
    QVERIFY(dialog && dialog->isVisible());
    snapshot(*dialog, name);
    TRY_COMPARE(clippedWidget(*dialog), QString());
    auto* table = dialog->findChild<QTableView*>();
    QVERIFY(table->horizontalHeader()->length() <= table->viewport()->width());
    dialog->close();
  }
  void checkFit(const QString& name) {
    snapshot(*panel_, name);
    TRY_COMPARE(clippedWidget(*panel_), QString());
    const int least = panel_->minimumSizeHint().width(), width = area_->viewport()->width();
    QVERIFY2(least <= width, qPrintable(QString("%1 needs %2 pixels of %3").arg(name).arg(least).arg(width)));
  }
};

QTEST_MAIN(ReconstructionPanelLayoutTest)
#include "ReconstructionPanelLayoutTest.moc"
