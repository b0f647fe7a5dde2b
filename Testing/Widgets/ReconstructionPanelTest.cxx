#include "ReconstructionPanelFixture.h"
#include "Widgets/FitChart.h"
#include "Widgets/PreviewView.h"
#include "Widgets/SlicesDialog.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QProgressBar>
#include <QSignalSpy>
#include <QSpinBox>
#include <QTableView>
#include <QTemporaryDir>
#include <QToolButton>

using namespace innergs::ui;
using innergs::Phase;

class ReconstructionPanelTest : public ReconstructionPanelFixture {
  Q_OBJECT

private Q_SLOTS:
  void asksForAScanFirst() {
    TRY_VERIFY(isShown("refusal"));
    QCOMPARE(line("refusal"), QString("Choose a scan to reconstruct."));
    QVERIFY(!button()->isEnabled());
    QVERIFY(host_->estimated.isEmpty());
    QCOMPARE(label("inputDescription"), QString("Choose a scan."));
  }

  void saysHowTheSlicesLieAndWhatItTakes() {
    choose("head");
    QCOMPARE(
        label("inputDescription"),
        QString::fromUtf8(
            "30 axial slices of 256 × 256; 0.9 × 0.9 × 4 mm; slice thickness not given: the slice distance"));
    QCOMPARE(child<QDoubleSpinBox>("sliceThickness")->text(), QString("auto (4 mm)"));
    QCOMPARE(child<QComboBox>("sliceAxis")->currentText(), QString("auto (K)"));
    QCOMPARE(label("gridExplanation"), QString("Cubes of 0.9 mm, the finest spacing of all scans."));
    TRY_VERIFY(button()->isEnabled());
    QCOMPARE(label("estimateText"), QString("Takes about 2 minutes, 850 MB of memory (16.0 GB free)."));
    QCOMPARE(label("deviceReason"), host_->nextEstimate.reason);
    QVERIFY(!isShown("refusal"));
    snapshot(*area_, "panel-ready");
  }

  void saysWhereTheThicknessIsFrom() {
    VolumeInfo info = host_->volumes["head"];
    info.name = "Overlapping";
    info.sliceThickness = 8;
    host_->addVolume("overlapping", info);
    choose("overlapping");
    auto* thickness = child<QDoubleSpinBox>("sliceThickness");
    QVERIFY(label("inputDescription").endsWith("0.9 × 0.9 × 4 mm; slice thickness 8 mm, as the file says"));
    QCOMPARE(thickness->text(), QString("auto (8 mm)"));
    // The file says nothing about another axis; a typed value is used as given.
    child<QComboBox>("sliceAxis")->setCurrentIndex(1);
    QVERIFY(label("inputDescription").endsWith("; slice thickness not given: the slice distance"));
    QCOMPARE(thickness->text(), QString("auto (0.9 mm)"));
    thickness->setValue(3);
    QVERIFY(label("inputDescription").endsWith(" mm"));
  }

  void saysWhatElseTheFileSaysOfTheSlices() {
    VolumeInfo info = host_->volumes["head"];
    info.name = "Interleaved";
    info.passes = 2;
    host_->addVolume("interleaved", info);
    choose("interleaved");
    QVERIFY(label("inputDescription").endsWith("; acquired in 2 interleaved passes"));
    child<QComboBox>("sliceAxis")->setCurrentIndex(1); // times are of slices along K
    QVERIFY(!label("inputDescription").contains("passes"));
    info.name = "Tracked";
    info.passes = 0;
    info.hasPoses = true;
    host_->addVolume("tracked", info);
    select(rows()[0]->findChild<Selector*>("inputSelector"), "tracked");
    QVERIFY(label("inputDescription").endsWith("; each slice at a place of its own"));
  }

  void changesInOneGoAreEstimatedOnce() {
    choose("head");
    TRY_COMPARE(host_->estimated.size(), 1);
    child<QComboBox>("preset")->setCurrentIndex(0);
    child<QComboBox>("preset")->setCurrentIndex(2);
    child<QDoubleSpinBox>("sliceThickness")->setValue(3);
    TRY_COMPARE(host_->estimated.size(), 2);
    TRY_VERIFY(!isEstimateAwaited());
    QCOMPARE(host_->estimated.size(), 2);
    QCOMPARE(host_->estimated.last().settings.preset, innergs::Preset::Best);
    QCOMPARE(host_->estimated.last().inputs[0].sliceThickness, 3.0);
  }

  void aLateEstimateIsShown() {
    host_->nextEstimate.seconds = 0;
    choose("head");
    TRY_COMPARE(label("estimateText"), QString("Takes 850 MB of memory (16.0 GB free)."));
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    host_->nextEstimate.seconds = 7200;
    Q_EMIT host_->estimateChanged();
    TRY_VERIFY(label("estimateText").startsWith("Takes about 2 hours, 850 MB"));
    QCOMPARE(changed.count(), 0);
  }

  void aRefusalIsSaidAndDisablesTheButton() {
    host_->nextEstimate.refusal = "The fit needs 40 GB and 16 GB are free: choose the preset fast.";
    choose("head");
    TRY_VERIFY(isShown("refusal"));
    TRY_COMPARE(line("refusal"), host_->nextEstimate.refusal);
    QVERIFY(!button()->isEnabled());
    // Memory freed by other programs is noticed without a change of the request.
    host_->nextEstimate.memory = 40'000'000'000;
    host_->nextEstimate.available = 16'000'000'000;
    Q_EMIT host_->estimateChanged();
    TRY_VERIFY(label("estimateText").contains("40"));
    QVERIFY(!button()->isEnabled());
    host_->nextEstimate.available = 64'000'000'000;
    host_->nextEstimate.refusal.clear();
    TRY_VERIFY(button()->isEnabled());
    child<QComboBox>("preset")->setCurrentIndex(0);
    TRY_VERIFY(button()->isEnabled());
    QVERIFY(!isShown("refusal"));
    innergs::Settings wrong;
    wrong.maxGaussians = 10;
    wrong.gaussians = 20;
    Request request = panel_->request();
    request.settings = wrong;
    panel_->setRequest(request);
    TRY_VERIFY(line("refusal").contains("must not be below the number at the start"));
    QVERIFY(!button()->isEnabled());
  }

  void aSingleSliceIsRefused() {
    host_->addVolume("flat", {"Localiser", {256, 256, 1}, {1, 1, 5}, 2, "axial"});
    choose("flat");
    TRY_VERIFY(line("refusal").startsWith("'Localiser' has a single slice along K"));
    QVERIFY(!button()->isEnabled());
    QCOMPARE(button()->toolTip(), line("refusal"));
    QVERIFY(host_->estimated.isEmpty());
    child<QComboBox>("sliceAxis")->setCurrentIndex(1); // I
    TRY_VERIFY(button()->isEnabled());
  }

  void theSameScanTwiceIsRefused() {
    choose("head");
    QTest::mouseClick(child<QToolButton>("addInput"), Qt::LeftButton);
    QCOMPARE(rows().size(), 2);
    select(rows()[1]->findChild<Selector*>(), "head");
    TRY_VERIFY(line("refusal").contains("twice"));
    QTest::mouseClick(rows()[0]->findChild<QToolButton*>("removeInput"), Qt::LeftButton);
    TRY_VERIFY(button()->isEnabled());
    QCOMPARE(panel_->request().inputs.size(), 1);
  }

  void everyPhaseIsNamed() {
    start();
    QString last = label("phaseText");
    double fraction = 0;
    for (const Phase phase :
         {Phase::Aligning, Phase::Predicting, Phase::Initialising, Phase::Tracking, Phase::Fitting,
          Phase::Refining, Phase::Rendering, Phase::Judging, Phase::Estimating}) {
      host_->sendProgress(phase, fraction += 0.1, 1, 0.01, 25, 100);
      TRY_VERIFY2(label("phaseText") != last, phaseName(phase));
      last = label("phaseText");
      QVERIFY2(!last.isEmpty(), phaseName(phase));
    }
    host_->sendCancelled();
  }

  /// A user's session: start, watch, cancel, start again, done.
  void startCancelRestartFinish() {
    host_->cancelsByItself = false;
    choose("head");
    TRY_VERIFY(button()->isEnabled());
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
    TRY_COMPARE(label("phaseText"), QString("Fitting: iteration 34 of 100"));
    QCOMPARE(child<QProgressBar>("progressBar")->text(), QString("34 %"));
    QCOMPARE(label("remainingText"), QString("about 4 minutes left"));
    QVERIFY(label("fitNumbers").contains("30.8 dB on the fitted samples, not held out"));
    QCOMPARE(label("fitNote"), QString("On the CPU, as asked."));
    QVERIFY(child<FitChart>("fitChart")->isVisible());
    QCOMPARE(child<FitChart>("fitChart")->points(), 3);
    QVERIFY(child<PreviewView>("preview")->isVisible());
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

  void judgingHasAPhaseOfItsOwn() {
    host_->cancelsByItself = false;
    start();
    host_->sendProgress(Phase::Fitting, 0.3, 99, 0.003, 30, 60);
    host_->sendProgress(Phase::Fitting, 0.31, 100, 0.002, 30.75, 55);
    host_->sendProgress(Phase::Judging, 0.6, 12, 0.002, 38, 40);
    QCOMPARE(label("phaseText"), QString("Judging the quality (second fit): iteration 12 of 100"));
    QCOMPARE(label("remainingText"), QString("about 40 seconds left"));
    QCOMPARE(child<QProgressBar>("progressBar")->text(), QString("60 %"));
    // Chart and the figure next to it show the same quantity: that of the fit's last iteration.
    QCOMPARE(child<FitChart>("fitChart")->points(), 2);
    QVERIFY(label("fitNumbers").contains("30.8 dB on the fitted samples, not held out"));
    QVERIFY(label("fitNumbers").contains("after iteration 100"));
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(label("phaseText").contains("finished model is kept"));
    // An end without judging the quality does not advise ticking a box that is ticked.
    Report report = FakeHost::exampleReport();
    report.quality.clear();
    report.heldOutPsnr = NAN;
    report.judging = innergs::Judging::Stopped;
    report.warnings = QStringList("Judging the quality was stopped: the result itself is complete.");
    host_->sendFinished(report);
    QVERIFY(!isShown("heldOutQuality"));
    QVERIFY(!isShown("qualityVerdict"));
    QVERIFY(line("resultWarnings").contains("stopped"));
  }

  void theUncertaintyIsAskedForAndStated() {
    host_->cancelsByItself = false;
    choose("head");
    QVERIFY(!panel_->request().estimateUncertainty);
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    QTest::mouseClick(child<QCheckBox>("estimateUncertainty"), Qt::LeftButton, {}, {5, 5});
    QCOMPARE(changed.count(), 1);
    QVERIFY(panel_->request().estimateUncertainty);
    TRY_VERIFY(host_->estimated.last().estimateUncertainty); // its time and memory count before the start
    clickWhenEnabled();
    QVERIFY(host_->requests.last().estimateUncertainty);
    host_->sendProgress(Phase::Estimating, 0.8, 3, 0.002, 38, 20);
    TRY_COMPARE(label("phaseText"), QString("Estimating the uncertainty"));
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(label("phaseText").contains("finished model is kept"));
    Report report = FakeHost::exampleReport();
    report.uncertainty = "Its 90 % intervals held 91 % of 4,000 voxels.";
    host_->sendFinished(report);
    QCOMPARE(label("resultUncertainty"), "Uncertainty: " + report.uncertainty);
    finish(FakeHost::exampleReport());
    QVERIFY(!isShown("resultUncertainty"));
  }

  void theChartTellsEnsemblesAndHalfResolutionApart() {
    host_->cancelsByItself = false;
    start();
    const auto iterations = [&] { // of 100, two members of 50
      for (int n = 1; n <= 100; ++n) {
        const int own = (n - 1) % 50;
        host_->sendProgress(Phase::Fitting, 0.01 * n, n, 0.1 / (own + 1), 20 + 0.2 * own);
      }
    };
    iterations();
    const auto* chart = child<FitChart>("fitChart");
    QCOMPARE(chart->lines(), 1);
    QVERIFY(!isShown("chartNote"));
    host_->sendFinished(FakeHost::exampleReport());
    host_->members = 2;
    host_->coarseIterations = 10;
    clickWhenEnabled();
    iterations();
    QCOMPARE(chart->lines(), 4); // each at half resolution, then at full
    TRY_VERIFY(isShown("chartNote"));
    QVERIFY(label("chartNote").contains("An ensemble of 2 models"));
    QVERIFY(label("chartNote").contains("half resolution"));
    snapshot(*area_, "panel-ensemble");
    const QImage drawn = child<FitChart>("fitChart")->grab().toImage();
    host_->sendFinished(FakeHost::exampleReport());
    QVERIFY(isShown("chartNote"));
    host_->members = 1;
    host_->coarseIterations = 0;
    clickWhenEnabled();
    iterations();
    QVERIFY(child<FitChart>("fitChart")->grab().toImage() != drawn); // marks and gaps are drawn
  }

  void anErrorStaysUntilTheNextStart() {
    start();
    host_->sendProgress(Phase::Fitting, 0.1, 5, 0.02, 20);
    host_->sendFailed("The memory ran out: choose a smaller region");
    QVERIFY(line("message").startsWith("The memory ran out: choose a smaller region.\n"));
    QVERIFY(!isShown("progressCard"));
    child<QComboBox>("preset")->setCurrentIndex(0);
    TRY_VERIFY(!isEstimateAwaited());
    QVERIFY(isShown("message"));
    snapshot(*area_, "panel-error");
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(!isShown("message"));
    QVERIFY(host_->isRunning());
  }

  void aRefusedStartIsAnError() {
    choose("head");
    TRY_VERIFY(button()->isEnabled());
    host_->refusal = "The scan was removed: choose another.";
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(line("message").startsWith(host_->refusal));
    QCOMPARE(button()->text(), QString("&Reconstruct"));
    QVERIFY(button()->isEnabled());
  }

  void requestsComeBack() {
    Request request;
    request.inputs = {{"head", 3.5, 2, 2}, {"side", 0, 0, -1, "brain"}};
    request.maskId = "brain";
    request.settings.fill = -1024;
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
    request.estimateUncertainty = true;
    request.evaluateQuality = false;
    request.qualityGap = 3;
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    panel_->setRequest(request);
    QCOMPARE(changed.count(), 0);
    const Request back = panel_->request();
    QCOMPARE(back.inputs, request.inputs);
    QCOMPARE(back.maskId, request.maskId);
    QCOMPARE(back.settings.fill, -1024.0);
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
    QCOMPARE(back.estimateUncertainty, request.estimateUncertainty);
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

  void theValueOutsideAMaskIsAskedForWhereThereIsOne() {
    auto* fill = child<QDoubleSpinBox>("fillValue");
    QVERIFY(!fill->isEnabled());
    QCOMPARE(panel_->request().settings.fill, 0.0);
    child<Selector>("maskSelector")->setCurrentId("brain");
    QVERIFY(fill->isEnabled());
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    fill->setValue(7.5);
    QCOMPARE(changed.count(), 1);
    QCOMPARE(panel_->request().settings.fill, 7.5);
  }

  void slicesThatMovedGetTransforms() {
    auto* create = child<QPushButton>("createSliceTransforms");
    QVERIFY(!isShown("slicesLine")); // there is no result
    start();
    host_->result = true;
    host_->sendFinished(FakeHost::exampleReport());
    QVERIFY(isShown("slicesLine"));
    QVERIFY(!create->isEnabled() && !child<QPushButton>("showSlices")->isEnabled());
    QVERIFY2(create->toolTip().startsWith("Nothing to create: "), qPrintable(create->toolTip()));

    host_->slices = FakeHost::exampleSlices();
    Q_EMIT host_->modelsChanged();
    QVERIFY(create->isEnabled());
    QTest::mouseClick(create, Qt::LeftButton);
    QCOMPARE(host_->transformFolders, QStringList{QString()}); // nodes have no folder
    QCOMPARE(line("slicesMessage"), QString("Made 6 transforms."));
    host_->slicesError = "There is no space left.";
    QTest::mouseClick(create, Qt::LeftButton);
    QCOMPARE(line("slicesMessage"), host_->slicesError);

    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(!isShown("slicesLine")); // the result that it is about is not shown
    host_->sendCancelled();
    QVERIFY(isShown("slicesLine"));
    host_->slices = FakeHost::exampleSlices();
    Q_EMIT host_->modelsChanged();
    QVERIFY(!isShown("slicesMessage"));
  }

  void slicesAreShownAndSaved() {
    host_->result = host_->slicesInFiles = true;
    host_->slices = FakeHost::exampleSlices();
    Q_EMIT host_->modelsChanged();
    QTest::mouseClick(child<QPushButton>("showSlices"), Qt::LeftButton);
    auto* dialog = panel_->findChild<SlicesDialog*>("slicesDialog");
    QVERIFY(dialog && dialog->isVisible());
    auto* table = dialog->findChild<QTableView*>("slicesTable");
    const auto text = [&](int row, int column) {
      return table->model()->index(row, column).data().toString();
    };
    QCOMPARE(table->model()->rowCount(), 6);
    QCOMPARE(text(1, 2), QString("3.25"));
    QCOMPARE(text(5, 6), QString::fromUtf8("–"));
    table->sortByColumn(2, Qt::DescendingOrder); // as numbers: 10.50 first
    QCOMPARE(text(0, 2), QString("10.50"));
    snapshot(*dialog, "slices-dialog");
    QTest::mouseClick(dialog->findChild<QPushButton*>("saveSlices"), Qt::LeftButton);
    QTemporaryDir folder;
    auto* save = dialog->findChild<QFileDialog*>("saveSlicesDialog");
    QVERIFY(save);
    const QString file = QDir(folder.path()).filePath("slices.tsv");
    Q_EMIT save->fileSelected(file);
    QCOMPARE(host_->savedTables, QStringList{file});
    QVERIFY(line("slicesMessage").contains("slices.tsv"));
    save->close();
    host_->slices = FakeHost::exampleSlices(); // of another result
    QPointer<SlicesDialog> old = dialog;
    Q_EMIT host_->modelsChanged();
    QVERIFY(old.isNull());

    QTest::mouseClick(child<QPushButton>("createSliceTransforms"), Qt::LeftButton);
    auto* choose = panel_->findChild<QFileDialog*>("transformsDialog");
    QVERIFY(choose);
    Q_EMIT choose->fileSelected(folder.path());
    QCOMPARE(host_->transformFolders, QStringList{folder.path()});
    QCOMPARE(host_->folder(), folder.path());
    choose->close();
  }

  void everyScanMayHaveAMaskOfItsOwn() {
    const auto own = [this](int row) { return rows()[row]->findChild<Selector*>("ownMaskSelector"); };
    host_->masks = {{"brain", "Brain"}, {"cord", "Cord"}};
    Q_EMIT host_->volumesChanged();
    choose("head");
    QVERIFY(!own(0)->isVisible()); // one scan has one mask
    QCOMPARE(label("maskLabel"), QString("Mas&k:"));
    QTest::mouseClick(child<QToolButton>("addInput"), Qt::LeftButton);
    select(rows()[1]->findChild<Selector*>(), "side");
    QVERIFY(own(0)->isVisible() && own(1)->isVisible());
    QCOMPARE(label("maskLabel"), QString("Mas&k for all:"));
    select(child<Selector>("maskSelector"), "brain");
    QVERIFY(panel_->request().inputs[0].maskId.isEmpty());
    QCOMPARE(panel_->request().maskId, QString("brain"));
    select(child<Selector>("maskSelector"), "");
    auto* fill = child<QDoubleSpinBox>("fillValue");
    QVERIFY(!fill->isEnabled());
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    select(own(1), "cord");
    QVERIFY(changed.count() > 0);
    QVERIFY(fill->isEnabled());
    QCOMPARE(panel_->request().inputs[1].maskId, QString("cord"));
    QVERIFY(panel_->request().inputs[0].maskId.isEmpty());
    host_->masks.remove("cord"); // what is gone is chosen no longer
    Q_EMIT host_->volumesChanged();
    QVERIFY(panel_->request().inputs[1].maskId.isEmpty());
    select(own(1), "brain");
    QTest::mouseClick(rows()[0]->findChild<QToolButton*>("removeInput"), Qt::LeftButton);
    QVERIFY(own(0)->isVisible()); // it still counts
    QCOMPARE(panel_->request().inputs[0].maskId, QString("brain"));
    select(own(0), "");
    QVERIFY(!own(0)->isVisible());
  }

  void slicesMayLieWhereASequenceSays() {
    const auto places = [this] { return rows()[0]->findChild<Selector*>("slicePosesSelector"); };
    choose("head");
    QVERIFY(!places()->isVisible()); // few scenes have any
    host_->slicePoses = {{"tracked", "Tracked probe"}};
    Q_EMIT host_->volumesChanged();
    QVERIFY(places()->isVisible());
    QVERIFY(panel_->request().inputs[0].posesId.isEmpty());
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    select(places(), "tracked");
    QVERIFY(changed.count() > 0);
    const Request request = panel_->request();
    QCOMPARE(request.inputs[0].posesId, QString("tracked"));
    panel_->setRequest({});
    QVERIFY(panel_->request().inputs.isEmpty());
    panel_->setRequest(request);
    QCOMPARE(panel_->request().inputs[0].posesId, QString("tracked"));
  }

  /// Showing a script's request does not change it.
  void numbersStayAsTheyWereSet() {
    choose("head");
    Request request = panel_->request();
    request.inputs[0].sliceThickness = 0.8765432109;
    request.grid = OutputGrid::Spacing;
    request.spacing = 0.01234567891;
    request.heldOutFraction = 0.12345678;
    request.qualityGap = 100;
    panel_->setRequest(request);
    for (const char* name : {"outputSpacing", "sliceThickness"}) {
      child<QDoubleSpinBox>(name)->setFocus();
      child<QDoubleSpinBox>(name)->interpretText();
    }
    child<QComboBox>("preset")->setCurrentIndex(0);
    const Request back = panel_->request();
    QCOMPARE(back.inputs, request.inputs);
    QCOMPARE(back.spacing, request.spacing);
    QCOMPARE(back.heldOutFraction, request.heldOutFraction);
    QCOMPARE(back.qualityGap, request.qualityGap);
    auto* spacing = child<QDoubleSpinBox>("outputSpacing");
    spacing->setFocus();
    spacing->selectAll();
    QTest::keyClicks(spacing, "0.9375");
    QTest::keyClick(spacing, Qt::Key_Tab);
    QCOMPARE(panel_->request().spacing, 0.9375);
    QCOMPARE(spacing->text(), QString("0.9375 mm"));
    QCOMPARE(panel_->request().inputs, request.inputs);
  }

  void aVolumeThatComesIsNoEdit() {
    choose("head");
    TRY_COMPARE(host_->estimated.size(), 1);
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    host_->addVolume("new", {"New", {9, 9, 9}, {1, 1, 1}, 2, "axial"});
    TRY_COMPARE(host_->estimated.size(), 2);
    QCOMPARE(changed.count(), 0);
  }

  void hiddenItEstimatesNothing() {
    choose("head");
    TRY_COMPARE(host_->estimated.size(), 1);
    area_->hide();
    Q_EMIT host_->estimateChanged();
    Q_EMIT host_->volumesChanged();
    TRY_VERIFY(!isEstimateAwaited());
    QCOMPARE(host_->estimated.size(), 1);
    area_->show();
    TRY_COMPARE(host_->estimated.size(), 2);
  }

  void notesOfTheFitLeaveTheDeviceAsItIs() {
    start();
    host_->sendProgress(Phase::Fitting, 0.6, 40, 0.01, 30, 9, "Judging the quality by a second fit.");
    QCOMPARE(label("deviceReason"), host_->nextEstimate.reason);
    TRY_COMPARE(label("fitNote"), QString("Judging the quality by a second fit."));
  }

  void theShownScanIsSuggested() {
    panel_->suggestInput("side");
    QCOMPARE(panel_->request().inputs[0].id, QString("side"));
    panel_->suggestInput("thin");
    QCOMPARE(panel_->request().inputs[0].id, QString("thin"));
    child<QDoubleSpinBox>("sliceThickness")->setValue(2); // the user's
    panel_->suggestInput("side");
    QCOMPARE(panel_->request().inputs[0].id, QString("thin"));
    panel_->setRequest({});
    choose("head");
    panel_->suggestInput("side");
    QCOMPARE(panel_->request().inputs[0].id, QString("head"));
  }

  void aRemovedVolumeLeavesTheList() {
    choose("head");
    TRY_VERIFY(button()->isEnabled());
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    host_->removeVolume("head");
    QVERIFY(changed.count() > 0);
    QVERIFY(panel_->request().inputs.isEmpty());
    TRY_VERIFY(!button()->isEnabled());
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

  void whatEndedIsForgottenAndWhatRunsIsNot() {
    finish(FakeHost::exampleReport());
    QVERIFY(isShown("qualityCard"));
    panel_->forgetResult();
    QVERIFY(!isShown("qualityCard"));
    QVERIFY(!isShown("progressCard"));
    clickWhenEnabled();
    panel_->forgetResult();
    QVERIFY(isShown("progressCard"));
    host_->sendFailed("The scene was closed");
    QVERIFY(isShown("message"));
    panel_->forgetResult();
    QVERIFY(!isShown("message"));
  }

  void aTypedNumberCountsWhenEnterIsNotPressed() {
    choose("head");
    TRY_VERIFY(button()->isEnabled());
    auto* thickness = child<QDoubleSpinBox>("sliceThickness");
    thickness->setFocus();
    thickness->selectAll();
    QTest::keyClicks(thickness, "2.5");
    panel_->startOrCancel();
    QCOMPARE(host_->requests.last().inputs[0].sliceThickness, 2.5);
  }

  void aThicknessThatWouldBeRefusedCannotBeTyped() {
    choose("head"); // slices 4 mm apart
    auto* thickness = child<QDoubleSpinBox>("sliceThickness");
    thickness->setFocus();
    thickness->selectAll();
    QTest::keyClicks(thickness, "65");
    QTest::keyClick(thickness, Qt::Key_Return);
    QCOMPARE(thickness->value(), 64.0);
  }
};

QTEST_MAIN(ReconstructionPanelTest)
#include "ReconstructionPanelTest.moc"
