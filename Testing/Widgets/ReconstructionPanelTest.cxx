#include "Widgets/ReconstructionPanel.h"

#include "FakeHost.h"
#include "TestTools.h"
#include "Widgets/FitChart.h"
#include "Widgets/InputsTable.h"
#include "Widgets/LogPanel.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PreviewView.h"
#include "Widgets/Section.h"

#include <QCheckBox>
#include <QClipboard>
#include <QDoubleSpinBox>
#include <QGuiApplication>
#include <QKeySequence>
#include <QProgressBar>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QSignalSpy>
#include <QSpinBox>
#include <QToolButton>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>

using namespace innergs::ui;
using innergs::Phase;

class ReconstructionPanelTest : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void init() { make({}); }
  void cleanup() {
    area_.reset();
    host_.reset();
  }

  void asksForAScanFirst() {
    QTRY_VERIFY(isShown("refusal"));
    QCOMPARE(line("refusal"), QString("Choose a scan to reconstruct."));
    QVERIFY(!button()->isEnabled());
    QVERIFY(host_->estimated.isEmpty());
    QCOMPARE(label("inputDescription"), QString("Choose a scan."));
  }

  void saysHowTheSlicesLieAndWhatItTakes() {
    choose("head");
    QCOMPARE(label("inputDescription"), QString::fromUtf8("30 axial slices of 256 × 256; 0.9 × 0.9 × 4 mm"));
    QCOMPARE(child<QDoubleSpinBox>("sliceThickness")->text(), QString("auto (4 mm)"));
    QCOMPARE(child<QComboBox>("sliceAxis")->currentText(), QString("auto (K)"));
    QCOMPARE(label("gridExplanation"), QString("Cubes of 0.9 mm, the finest spacing of all scans."));
    QTRY_VERIFY(button()->isEnabled());
    QCOMPARE(label("estimateText"),
             QString("Takes about 2 minutes and 850 MB of memory (16.0 GB are free)."));
    QCOMPARE(label("deviceReason"), QString("On the CPU. The CUDA backend is not installed."));
    QVERIFY(!isShown("refusal"));
    snapshot(*area_, "panel-ready");
  }

  void changesInOneGoAreEstimatedOnce() {
    choose("head");
    QTRY_COMPARE(host_->estimated.size(), 1);
    child<QComboBox>("preset")->setCurrentIndex(0);
    child<QComboBox>("preset")->setCurrentIndex(2);
    child<QDoubleSpinBox>("sliceThickness")->setValue(3);
    QTRY_COMPARE(host_->estimated.size(), 2);
    QTest::qWait(400);
    QCOMPARE(host_->estimated.size(), 2);
    QCOMPARE(host_->estimated.last().settings.preset, innergs::Preset::Best);
    QCOMPARE(host_->estimated.last().inputs[0].sliceThickness, 3.0);
  }

  void aRefusalIsSaidAndDisablesTheButton() {
    host_->nextEstimate.refusal = "The fit needs 40 GB and 16 GB are free: choose the preset fast.";
    choose("head");
    QTRY_VERIFY(isShown("refusal"));
    QTRY_COMPARE(line("refusal"), host_->nextEstimate.refusal);
    QVERIFY(!button()->isEnabled());
    host_->nextEstimate.refusal.clear();
    child<QComboBox>("preset")->setCurrentIndex(0);
    QTRY_VERIFY(button()->isEnabled());
    QVERIFY(!isShown("refusal"));
    child<QSpinBox>("qualityGap");
    innergs::Settings wrong;
    wrong.maxGaussians = 10;
    wrong.gaussians = 20;
    Request request = panel_->request();
    request.settings = wrong;
    panel_->setRequest(request);
    QTRY_VERIFY(line("refusal").contains("must not be below the number at the start"));
    QVERIFY(!button()->isEnabled());
  }

  void theSameScanTwiceIsRefused() {
    choose("head");
    QTest::mouseClick(child<QToolButton>("addInput"), Qt::LeftButton);
    QCOMPARE(rows().size(), 2);
    select(rows()[1]->findChild<Selector*>(), "head");
    QTRY_VERIFY(line("refusal").contains("twice"));
    QTest::mouseClick(rows()[0]->findChild<QToolButton*>("removeInput"), Qt::LeftButton);
    QTRY_VERIFY(button()->isEnabled());
    QCOMPARE(panel_->request().inputs.size(), 1);
  }

  /// A person's path: start, watch, cancel, start again, done.
  void startCancelRestartFinish() {
    host_->cancelDelay = -1;
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    QCOMPARE(button()->text(), QString("&Reconstruct"));
    QTest::mouseClick(button(), Qt::LeftButton);
    QCOMPARE(host_->requests.size(), 1);
    QCOMPARE(host_->requests[0].inputs[0].id, QString("head"));
    QCOMPARE(button()->text(), QString("&Cancel"));
    QVERIFY(!child<QComboBox>("preset")->isEnabled());

    host_->sendProgress(Phase::Fitting, 0.25, 20, 0.01, 25, 200, "On the CPU, as asked.");
    host_->sendProgress(Phase::Fitting, 0.30, 30, 0.005, 28.25, 195);
    host_->sendProgress(Phase::Fitting, 0.34, 34, 0.002, 30.75, 190);
    host_->sendPreview();
    QTRY_COMPARE(label("phaseText"), QString("Fitting: sweep 34 of 100"));
    QCOMPARE(child<QProgressBar>("progressBar")->text(), QString("34 %"));
    QCOMPARE(label("remainingText"), QString("about 4 minutes left"));
    QVERIFY(label("fitNumbers").contains("30.8 dB on the fitted samples, not held out"));
    QCOMPARE(label("fitNote"), QString("On the CPU, as asked."));
    QVERIFY(child<FitChart>("fitChart")->isVisible());
    QCOMPARE(child<FitChart>("fitChart")->points(), 3);
    QVERIFY(child<PreviewView>("preview")->isVisible());
    QTest::qWait(400);
    snapshot(*area_, "panel-running");

    QTest::mouseClick(button(), Qt::LeftButton);
    QCOMPARE(host_->cancels, 1);
    QCOMPARE(button()->text(), QString::fromUtf8("Cancelling…"));
    QVERIFY(!button()->isEnabled());
    host_->sendProgress(Phase::Fitting, 0.35, 35, 0.002, 30.8, 189);
    QCOMPARE(button()->text(), QString::fromUtf8("Cancelling…"));
    QTest::mouseClick(button(), Qt::LeftButton);
    QCOMPARE(host_->cancels, 1);
    host_->sendCancelled();
    QCOMPARE(button()->text(), QString("&Reconstruct"));
    QVERIFY(button()->isEnabled());
    QVERIFY(child<QComboBox>("preset")->isEnabled());
    QVERIFY(line("message").startsWith("Cancelled"));
    QVERIFY(!isShown("progressCard"));

    QTest::mouseClick(button(), Qt::LeftButton);
    QCOMPARE(host_->requests.size(), 2);
    QVERIFY(!isShown("message"));
    QCOMPARE(child<QProgressBar>("progressBar")->value(), 0);
    QCOMPARE(child<FitChart>("fitChart")->points(), 0);
    host_->sendProgress(Phase::Rendering, 0.9, 100, 0.001, 33);
    host_->sendFinished(FakeHost::exampleReport());
    QCOMPARE(button()->text(), QString("&Reconstruct"));
    QVERIFY(isShown("qualityCard"));
    QVERIFY(!isShown("progressBar"));
  }

  void everyFigureSaysItsSamples() {
    finish(FakeHost::exampleReport());
    QCOMPARE(label("resultSummary"),
             QString("Done in 1 min 23 s. 74,088 Gaussians. On the CPU. The CUDA backend is not installed."));
    QVERIFY(label("qualityVerdict").startsWith("On slices that no method saw, InnerGS is 1.5 dB closer"));
    QVERIFY(label("qualitySamples").startsWith("Scored on held-out slices: Every 4th slice"));
    QCOMPARE(label("quality-1-0"), QString("InnerGS"));
    QCOMPARE(label("quality-1-1"), QString("31.62"));
    QCOMPARE(label("quality-2-0"), QString("Linear interpolation"));
    QVERIFY(label("heldOutQuality").startsWith("31.50 dB PSNR on held-out slices"));
    QVERIFY(label("trainingQuality").startsWith("38.25 dB PSNR on the fitted samples, not held out"));
    QVERIFY(line("resultWarnings").contains("thickness was set to 4 mm."));
    scrollDown();
    snapshot(*area_, "panel-finished");
  }

  void worseThanInterpolationIsSaid() {
    Report report = FakeHost::exampleReport();
    report.quality = {{"gaussians", 29, 0.9}, {"linear", 30.2, 0.92}, {"cubic", 30, 0.91}};
    finish(report);
    QVERIFY(
        label("qualityVerdict").contains("linear interpolation is 1.2 dB closer to the truth than InnerGS"));
  }

  void withoutHeldOutSamplesItSaysSo() {
    Report report;
    report.trainingPsnr = 40;
    finish(report);
    QVERIFY(label("heldOutQuality").startsWith("The quality between slices was not measured"));
    QVERIFY(!isShown("qualityTable"));
    QVERIFY(!isShown("resultWarnings"));
    QVERIFY(label("trainingQuality").contains("not held out"));
  }

  void anErrorStaysUntilTheNextStart() {
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    host_->sendProgress(Phase::Fitting, 0.1, 5, 0.02, 20);
    host_->sendFailed("The memory ran out: choose a smaller region");
    QVERIFY(line("message").startsWith("The memory ran out: choose a smaller region.\n"));
    QVERIFY(!isShown("progressCard"));
    child<QComboBox>("preset")->setCurrentIndex(0);
    QTest::qWait(400);
    QVERIFY(isShown("message"));
    snapshot(*area_, "panel-error");
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(!isShown("message"));
    QVERIFY(host_->isRunning());
  }

  void aRefusedStartIsAnError() {
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    host_->refusal = "The scan was removed: choose another.";
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(line("message").startsWith(host_->refusal));
    QCOMPARE(button()->text(), QString("&Reconstruct"));
    QVERIFY(button()->isEnabled());
  }

  void requestsComeBack() {
    Request request;
    request.inputs = {{"head", 3.5, 2, 2}, {"side", 0, 0, -1}};
    request.maskId = "brain";
    request.regionId = "box";
    request.grid = OutputGrid::Reference;
    request.spacing = 0.75;
    request.referenceId = "thin";
    request.outputVolumeId = "thin";
    request.settings.preset = innergs::Preset::Paper;
    request.settings.device = "cpu";
    request.settings.iterations = 12;
    request.settings.seed = 99;
    request.heldOutFraction = 0.125;
    request.evaluateQuality = false;
    request.qualityGap = 3;
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    panel_->setRequest(request);
    QCOMPARE(changed.count(), 0);
    const Request back = panel_->request();
    QCOMPARE(back.inputs, request.inputs);
    QCOMPARE(back.maskId, request.maskId);
    QCOMPARE(back.regionId, request.regionId);
    QCOMPARE(back.grid, request.grid);
    QCOMPARE(back.spacing, request.spacing);
    QCOMPARE(back.referenceId, request.referenceId);
    QCOMPARE(back.outputVolumeId, request.outputVolumeId);
    QCOMPARE(back.settings.preset, request.settings.preset);
    QCOMPARE(back.settings.device, request.settings.device);
    QCOMPARE(back.settings.iterations, request.settings.iterations);
    QCOMPARE(back.settings.seed, request.settings.seed);
    QCOMPARE(back.heldOutFraction, request.heldOutFraction);
    QCOMPARE(back.evaluateQuality, request.evaluateQuality);
    QCOMPARE(back.qualityGap, request.qualityGap);
    QVERIFY(isShown("referenceSelector"));
    QVERIFY(!isShown("outputSpacing"));
    panel_->setRequest({});
    QVERIFY(panel_->request().inputs.isEmpty());
    QCOMPARE(rows().size(), 1);
    child<QComboBox>("preset")->setCurrentIndex(0);
    QCOMPARE(changed.count(), 1);
  }

  void onlyWhatTheHostOffersIsShown() {
    QVERIFY(child<Selector>("maskSelector") && child<Selector>("regionSelector"));
    make({Host::Role::Input});
    QVERIFY(!child<Selector>("maskSelector") && !child<Selector>("regionSelector"));
    QVERIFY(!child<Selector>("referenceSelector") && !child<Selector>("outputVolumeSelector"));
    QCOMPARE(child<QComboBox>("outputGrid")->count(), 3);
  }

  void aRemovedVolumeLeavesTheList() {
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    host_->removeVolume("head");
    QVERIFY(changed.count() > 0);
    QVERIFY(panel_->request().inputs.isEmpty());
    QTRY_VERIFY(!button()->isEnabled());
  }

  void joinsARunThatGoesOn() {
    Request request;
    request.inputs = {{"head", 0, 1, -1}};
    host_->start(request);
    ReconstructionPanel second(host_.get());
    auto* cancel = second.findChild<QPushButton*>("reconstruct");
    QCOMPARE(cancel->text(), QString("&Cancel"));
    QCOMPARE(button()->text(), QString("&Cancel")); // the first panel saw the start too
    host_->sendCancelled();
    QCOMPARE(cancel->text(), QString("&Reconstruct"));
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

  /// Everything by Tab, arrows and Space; the focus stays on the button from start to end.
  void keyboardAlone() {
    auto* first = rows()[0]->findChild<Selector*>()->findChild<QComboBox*>();
    first->setFocus();
    QTest::keyClick(first, Qt::Key_Down);
    QCOMPARE(panel_->request().inputs.size(), 1);
    QTRY_VERIFY(button()->isEnabled());
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
    const QStringList expected{"inputSelector",  "sliceThickness", "sliceProfile",
                               "sliceAxis",      "addInput",       "maskSelector",
                               "regionSelector", "outputGrid",     "outputVolumeSelector",
                               "preset",         "device",         "evaluateQuality",
                               "sectionButton"};
    QVERIFY2(order == expected, qPrintable(order.join(' ')));
    QTest::keyClick(button(), Qt::Key_Space);
    QVERIFY(host_->isRunning());
    QCOMPARE(QApplication::focusWidget(), button());
    QTest::keyClick(QApplication::focusWidget(), Qt::Key_Space);
    QCOMPARE(host_->cancels, 1);
    QTRY_COMPARE(button()->text(), QString("&Reconstruct"));
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
    for (auto* field : panel_->findChildren<QWidget*>()) // and every field says what it is
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
    rows()[0]->firstField()->setFocus();
    QStringList order;
    while (QApplication::focusWidget() != child<QToolButton>("addInput") && order.size() < 20) {
      QWidget* at = QApplication::focusWidget();
      for (int r = 0; r < 3; ++r)
        if (rows()[r]->isAncestorOf(at)) order << QString::number(r);
      QTest::keyClick(at, Qt::Key_Tab);
    }
    QCOMPARE(order.join(""), QString("000001111122222"));
  }

  void aTypedNumberCountsWhenEnterIsNotPressed() {
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    auto* thickness = child<QDoubleSpinBox>("sliceThickness");
    thickness->setFocus();
    thickness->selectAll();
    QTest::keyClicks(thickness, "2.5");
    panel_->startOrCancel();
    QCOMPARE(host_->requests.last().inputs[0].sliceThickness, 2.5);
  }

  /// In every state, 400 pixels wide; the test runs once more at 150 %.
  void nothingIsClipped() {
    panel_->findChild<Section*>("advanced")->setOpen(true);
    Request request;
    request.inputs = {{"head", 0, 1, -1}, {"side", 0, 2, 0}};
    request.grid = OutputGrid::Spacing;
    panel_->setRequest(request);
    QTRY_VERIFY(button()->isEnabled());
    QTest::qWait(50);
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
    QTest::qWait(400);
    checkFit("panel-advanced-running");
    host_->sendFinished(FakeHost::exampleReport());
    QTest::qWait(50);
    checkFit("panel-advanced-finished");
    host_->sendFailed("The file cannot be read: choose another one, or export it anew from the scanner");
    QTest::qWait(50);
    checkFit("panel-advanced-error");
  }

  void coloursFollowADarkPalette() {
    const QPalette before = QApplication::palette();
    QPalette dark(QColor(53, 53, 53));
    dark.setColor(QPalette::Base, QColor(30, 30, 30));
    for (const auto role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText})
      dark.setColor(QPalette::Disabled, role, QColor(128, 128, 128));
    QApplication::setPalette(dark);
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    for (int i = 1; i < 30; ++i)
      host_->sendProgress(Phase::Fitting, i / 30.0, 3 * i, 0.02 * std::exp(-0.1 * i), 20 + 0.5 * i, 40);
    host_->sendPreview();
    QTest::qWait(400);
    snapshot(*panel_, "panel-dark-running");
    const QImage chart = child<FitChart>("fitChart")->grab().toImage();
    QVERIFY(qGray(chart.pixel(2, 2)) < 60);
    QVERIFY(brightest(chart) > 150); // its text
    QVERIFY(qGray(label_("phaseText")->grab().toImage().pixel(0, 0)) < 90);
    host_->sendFinished(FakeHost::exampleReport());
    snapshot(*panel_, "panel-dark-finished");
    QApplication::setPalette(before);
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

  void theLogIsCopied() {
    LogPanel log(host_.get());
    QVERIFY(showActive(log));
    Q_EMIT host_->logged("Opened head.nii.gz");
    choose("head");
    panel_->startOrCancel();
    host_->sendProgress(Phase::Fitting, 0.5, 1, 0.1, 20, 3, "On the CPU, as asked.");
    host_->sendFinished(FakeHost::exampleReport());
    for (const char* part : {"Opened head.nii.gz", "Reconstruction started.", "On the CPU, as asked.",
                             "Done in 1 min 23 s: 74,088 Gaussians.", "Warning: The slices are thicker",
                             "38.25 dB on the fitted samples, not held out.", "Settings: preset=balanced"})
      QVERIFY2(log.text().contains(part), part);
    QTest::mouseClick(log.findChild<QPushButton*>("copyLog"), Qt::LeftButton);
    QCOMPARE(QGuiApplication::clipboard()->text(), log.text() + '\n');
    panel_->startOrCancel();
    host_->sendFailed("It broke: do this.");
    QVERIFY(log.text().contains("Error: It broke: do this."));
    snapshot(log, "log");
  }

private:
  void make(const QVector<Host::Role>& roles) {
    area_.reset();
    host_ = std::make_unique<FakeHost>();
    if (!roles.isEmpty()) host_->roles = roles;
    area_ = std::make_unique<QScrollArea>();
    panel_ = new ReconstructionPanel(host_.get());
    area_->setWidget(panel_);
    area_->setWidgetResizable(true);
    area_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    area_->resize(400, 760);
    QVERIFY(showActive(*area_));
  }
  template <class T>
  T* child(const char* name) {
    return panel_->findChild<T*>(name);
  }
  QPushButton* button() { return child<QPushButton>("reconstruct"); }
  QLabel* label_(const char* name) { return child<QLabel>(name); }
  static int brightest(const QImage& image) {
    int most = 0;
    for (int y = 0; y < image.height(); ++y)
      for (int x = 0; x < image.width(); ++x)
        most = std::max(most, qGray(image.pixel(x, y)));
    return most;
  }
  QString label(const char* name) { return child<QLabel>(name)->text(); }
  QString line(const char* name) { return child<MessageLine>(name)->text(); }
  bool isShown(const char* name) { return child<QWidget>(name)->isVisible(); }
  QVector<InputRow*> rows() {
    QVector<InputRow*> found;
    for (auto* row : panel_->findChildren<InputRow*>())
      if (row->isVisible()) found << row;
    return found;
  }
  void select(Selector* selector, const QString& id) {
    auto* combo = selector->findChild<QComboBox*>();
    combo->setFocus();
    QTest::keyClick(combo, Qt::Key_Home);
    for (int i = 0; i < combo->count() && selector->currentId() != id; ++i)
      QTest::keyClick(combo, Qt::Key_Down);
    QCOMPARE(selector->currentId(), id);
  }
  void choose(const QString& id) { select(rows()[0]->findChild<Selector*>(), id); }
  void finish(const Report& report) {
    choose("head");
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    host_->sendFinished(report);
  }
  void scrollDown() {
    QTest::qWait(50);
    area_->verticalScrollBar()->setValue(area_->verticalScrollBar()->maximum());
  }
  void checkFit(const QString& name) {
    snapshot(*panel_, name);
    QTest::qWait(150); // the layout catches up
    const int least = panel_->minimumSizeHint().width(), width = area_->viewport()->width();
    QVERIFY2(least <= width, qPrintable(QString("%1 needs %2 pixels of %3").arg(name).arg(least).arg(width)));
    const QString clipped = clippedWidget(*panel_);
    QVERIFY2(clipped.isEmpty(), qPrintable(name + ": " + clipped));
  }

  std::unique_ptr<FakeHost> host_;
  std::unique_ptr<QScrollArea> area_;
  ReconstructionPanel* panel_ = nullptr;
};

QTEST_MAIN(ReconstructionPanelTest)
#include "ReconstructionPanelTest.moc"
