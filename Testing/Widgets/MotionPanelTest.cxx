#include "Widgets/MotionPanel.h"

#include "Core/Settings/SettingsTable.h"
#include "FakeHost.h"
#include "IO/RecoveredFit.h"
#include "Patience.h"
#include "TestTools.h"

#include <QCheckBox>
#include <QDir>
#include <QDoubleSpinBox>
#include <QFileDialog>
#include <QLabel>
#include <QLineEdit>
#include <QProgressBar>
#include <QPushButton>
#include <QSignalSpy>
#include <QSlider>
#include <QTemporaryDir>
#include <QToolButton>

using namespace innergs::ui;
using innergs::Phase;
using innergs::Progress;

/// A made-up dynamic scan and its model; the test is the worker.
class FakeMotion : public MotionHost {
  Q_OBJECT
public:
  QMap<QString, SeriesInfo> series;
  QMap<QString, MotionInfo> models;
  QVector<MotionRequest> requests;
  QVector<double> times;
  QString refusal, savedTo;
  double savedRate = -1;
  int cancels = 0;
  bool running = false;

  SeriesInfo seriesInfo(const QString& id) const override { return series.value(id); }
  bool start(const MotionRequest& request) override {
    if (!refusal.isEmpty()) {
      Q_EMIT failed(refusal);
      return false;
    }
    requests << request;
    running = true;
    Q_EMIT started();
    return true;
  }
  void cancel() override { ++cancels; }
  void sendCancelled() {
    running = false;
    Q_EMIT cancelled();
  }
  bool isRunning() const override { return running; }
  MotionInfo preview;
  QVector<double> previewTimes;
  MotionInfo previewInfo() const override { return preview; }
  void setPreviewTime(double seconds) override {
    preview.now = seconds;
    previewTimes << seconds;
  }
  MotionInfo motionInfo(const QString& id) const override { return models.value(id); }
  void setTime(const QString& id, double seconds) override {
    models[id].now = seconds;
    times << seconds;
  }
  bool savesFrames() const override { return true; }
  QString saveFrames(const QString&, double rate, const QString& file) override {
    savedTo = file;
    savedRate = rate;
    return {};
  }
};

class MotionPanelTest : public QObject {
  Q_OBJECT

  FakeHost* host_ = nullptr;
  FakeMotion* motion_ = nullptr;
  MotionPanel* panel_ = nullptr;

  template <class Part>
  Part* part(const char* name) {
    return panel_->findChild<Part*>(name);
  }
  QString about() { return part<QLabel>("motionAbout")->text(); }
  QPushButton* run() { return part<QPushButton>("motionRun"); }
  void addModel(const QString& id, const QString& name, const MotionInfo& info) {
    motion_->models[id] = info;
    host_->models[id].name = name;
    Q_EMIT host_->modelsChanged();
  }

  static QString keep(const QString& folder) {
    innergs::TimeSeries series;
    series.geometry.size = {2, 2, 2};
    series.times = {0, 0.7};
    series.frames.assign(2, {0, 1, 2, 3, 4, 5, 6, 7});
    innergs::StoppedDynamicFit fit;
    fit.field = innergs::emptyField(innergs::DynamicKind::Intensity, series, {1, 0}, 2.5);
    fit.field.canonical.gaussians.resize(1);
    fit.field.canonical.gaussians[0].quaternion[0] = 1;
    fit.field.change = {0, 0.7, 4};
    fit.field.changes.assign(4, 0.f);
    fit.state.step = 120;
    fit.state.moments.assign(2, 0.f);
    innergs::RecoveredFit about;
    about.inputs = "Wrist";
    about.settings.kind = innergs::DynamicKind::Motion;
    about.settings.knots = 9;
    about.iterations = 400;
    about.interval = 0.7;
    return QString::fromStdU16String(
        innergs::writeRecoveredFit(fit, about, folder.toStdU16String()).u16string());
  }

private Q_SLOTS:
  void init() {
    host_ = new FakeHost;
    motion_ = new FakeMotion;
    host_->motionHost = motion_;
    host_->series = {{"wrist", "Wrist"}, {"bold", "BOLD"}};
    motion_->series["wrist"] = {"Wrist", 38, {64, 64, 12}, true, 0, 18.5, {}};
    motion_->series["bold"] = {"BOLD", 48, {64, 64, 33}, false, 0, 0, {}};
    panel_ = new MotionPanel(host_);
    QVERIFY(showActive(*panel_));
  }
  void cleanup() {
    delete panel_;
    delete motion_;
    delete host_;
  }

  void saysWhatAScanIs() {
    QVERIFY(!run()->isEnabled());
    QVERIFY(about().contains("4D"));
    panel_->setSeriesId("wrist");
    QVERIFY(run()->isEnabled());
    QCOMPARE(about(), QString("38 frames of 64 × 64 × 12 voxels, from 0 s to 18.5 s."));
    panel_->setSeriesId("bold");
    QVERIFY(about().contains("give the time between frames"));
    part<QDoubleSpinBox>("motionInterval")->setValue(2);
    QVERIFY(about().contains("to 94 s"));
    motion_->series["wrist"].problem = "It has a vector per voxel: choose another.";
    part<QDoubleSpinBox>("motionInterval")->setValue(part<QDoubleSpinBox>("motionInterval")->minimum());
    panel_->setSeriesId("wrist");
    QVERIFY(!run()->isEnabled());
    QVERIFY(about().contains("vector"));
  }

  void runsAndReports() {
    panel_->setSeriesId("wrist");
    part<QComboBox>("motionKind")->setCurrentIndex(1);
    part<QDoubleSpinBox>("motionRate")->setValue(10);
    QTest::mouseClick(run(), Qt::LeftButton);
    QCOMPARE(motion_->requests.size(), 1);
    const MotionRequest& request = motion_->requests[0];
    QCOMPARE(request.seriesId, QString("wrist"));
    QVERIFY(request.settings.kind == innergs::DynamicKind::Motion);
    QCOMPARE(request.rate, 10.0);
    QCOMPARE(request.interval, 0.0);
    QVERIFY(request.evaluateQuality);
    Progress progress;
    progress.phase = Phase::Tracking;
    progress.fraction = 0.25;
    progress.remaining = 41;
    Q_EMIT motion_->progressed(progress);
    QCOMPARE(part<QProgressBar>("motionProgress")->value(), 250);
    QVERIFY(part<QLabel>("motionPhase")->text().contains("40 seconds"));
    snapshot(*panel_, "motion-running");
    addModel("m", "Wrist model", {true, 0, 18.5, 0, "motion"});
    motion_->running = false;
    MotionReport report;
    report.modelId = "m";
    report.quality = {{"gaussians", 42.13, 0.9747}, {"linear", 34.44, 0.9345}, {"previous", 30.2, 0.8926}};
    report.samples = "4 of 38 frames, which no method saw.";
    report.gaussians = 8192;
    report.seconds = 37;
    QSignalSpy chosen(panel_, &MotionPanel::modelIdChanged);
    Q_EMIT motion_->finished(report);
    QCOMPARE(chosen.size(), 1);
    QCOMPARE(panel_->modelId(), QString("m"));
    QVERIFY(!part<QProgressBar>("motionProgress")->isVisible());
    for (const char* text : {"42.13", "34.44", "Linear in time", "4 of 38 frames"})
      QVERIFY2(part<QLabel>("motionQuality")->text().contains(text), text);
    QVERIFY(part<QLabel>("motionQuality")->isVisible());
    snapshot(*panel_, "motion-done");
  }

  void itsSettingsAreTheTables() {
    panel_->setSeriesId("wrist");
    for (const innergs::Setting& row : innergs::settingsTable())
      if (row.group == innergs::Setting::Group::Dynamic && row.name != std::string("kind"))
        QVERIFY2(panel_->findChild<QWidget*>(row.name), row.name);
    QCOMPARE(part<QComboBox>("motionKind")->count(), 1 + 3);
    part<QDoubleSpinBox>("knots")->setValue(9);
    part<QComboBox>("motionKind")->setCurrentIndex(2);
    QVERIFY(!part<QDoubleSpinBox>("rounds")->isEnabled()); // intensities are solved for
    part<QComboBox>("motionKind")->setCurrentIndex(3);
    QVERIFY(part<QDoubleSpinBox>("rounds")->isEnabled());
    run()->click();
    const innergs::Settings& asked = motion_->requests[0].settings;
    QVERIFY(asked.kind == innergs::DynamicKind::Network);
    QVERIFY(asked.knots == 9);
    QVERIFY(!asked.rounds);
  }

  void takesTheFileOfSliceTimes() {
    panel_->setSeriesId("bold");
    QTemporaryDir folder;
    const QString file = folder.filePath("task.json");
    QFile json(file);
    QVERIFY(json.open(QFile::WriteOnly));
    json.write("{}");
    json.close();
    part<QToolButton>("motionChooseSliceTimes")->click();
    auto* dialog = part<QFileDialog>("motionSliceTimesDialog");
    QVERIFY(dialog);
    Q_EMIT dialog->fileSelected(file);
    QCOMPARE(QDir::fromNativeSeparators(part<QLineEdit>("motionSliceTimes")->text()), file);
    QCOMPARE(host_->folder(), folder.path());
    run()->click();
    QCOMPARE(QDir::fromNativeSeparators(motion_->requests.last().sliceTimesFile), file);
    motion_->sendCancelled();
    part<QComboBox>("motionKind")->setCurrentIndex(1); // where Gaussians move, a frame is one moment
    QVERIFY(!part<QLineEdit>("motionSliceTimes")->isEnabled());
    run()->click();
    QCOMPARE(motion_->requests.last().sliceTimesFile, QString());
    motion_->sendCancelled();
    part<QComboBox>("motionKind")->setCurrentIndex(2);
    QVERIFY(part<QLineEdit>("motionSliceTimes")->isEnabled());
  }

  void theDeviceIsChosenAndSaysWhy() {
    panel_->setSeriesId("wrist");
    auto* device = part<QComboBox>("device");
    run()->click();
    QCOMPARE(motion_->requests.last().settings.device, std::string("auto"));
    Progress progress;
    progress.note = "On the CPU. There is no driver.";
    Q_EMIT motion_->progressed(progress);
    QCOMPARE(part<QLabel>("deviceReason")->text(), QString::fromStdString(progress.note));
    motion_->sendCancelled();
    device->setCurrentIndex(device->findData("cpu"));
    run()->click();
    QCOMPARE(motion_->requests.last().settings.device, std::string("cpu"));
  }

  void theSliderShowsTheModelSoFar() {
    panel_->setSeriesId("wrist");
    run()->click();
    auto* slider = part<QSlider>("motionTimeSlider");
    QVERIFY(!slider->isEnabled());
    motion_->preview = {true, 0, 18.5, 0, "motion"};
    Q_EMIT motion_->previewed();
    QVERIFY(slider->isEnabled());
    QVERIFY(part<QLabel>("motionAboutModel")->text().contains("so far"));
    QVERIFY(!part<QPushButton>("motionSaveModel")->isEnabled());
    slider->setValue(7250);
    QCOMPARE(motion_->previewTimes, QVector<double>{7.25});
    QVERIFY(motion_->times.isEmpty());
    snapshot(*panel_, "motion-preview");
    Q_EMIT motion_->previewed(); // a newer one at the same time
    QCOMPARE(part<QDoubleSpinBox>("motionTimeValue")->value(), 7.25);
    motion_->sendCancelled();
    QVERIFY(!slider->isEnabled());
  }

  void cancelsAndTellsErrors() {
    panel_->setSeriesId("wrist");
    QTest::mouseClick(run(), Qt::LeftButton);
    QTest::mouseClick(run(), Qt::LeftButton);
    QCOMPARE(motion_->cancels, 1);
    QVERIFY(!run()->isEnabled()); // once
    motion_->sendCancelled();
    QVERIFY(run()->isEnabled());
    motion_->refusal = "All frames are equal: choose another scan.";
    QTest::mouseClick(run(), Qt::LeftButton);
    QVERIFY(panel_->findChild<QWidget*>("motionMessage")->isVisible());
    QVERIFY(run()->isEnabled());
  }

  void goesOnFromWhatWasKept() {
    const QTemporaryDir folder;
    host_->recovery = folder.path();
    innergs::Model still; // of a scan at rest: not for this panel
    still.field.gaussians.resize(1);
    innergs::writeRecoveredFit(still, {}, folder.path().toStdU16String());
    panel_->setSeriesId("wrist");
    run()->click();
    const QString file = keep(folder.path());
    motion_->sendCancelled();
    QVERIFY(part<QWidget>("motionRecoveryLine")->isVisible());
    const auto told = [&] {
      QString text;
      for (const QLabel* label : part<QWidget>("motionRecovery")->findChildren<QLabel*>())
        text += label->text();
      return text;
    };
    QVERIFY2(told().contains("Wrist") && told().contains("120 of 400"), qPrintable(told()));
    QVERIFY(!part<QWidget>("motionMessage")->property("text").toString().contains("nothing"));
    snapshot(*panel_, "motion-recovery");
    part<QPushButton>("motionGoOn")->click();
    QCOMPARE(part<QComboBox>("motionKind")->currentIndex(), 1);
    QCOMPARE(part<QDoubleSpinBox>("motionInterval")->value(), 0.7);
    run()->click();
    const MotionRequest& asked = motion_->requests.last();
    QCOMPARE(asked.resumeFile, file);
    QVERIFY(asked.settings.knots == 9);
    QCOMPARE(asked.interval, 0.7);
    QVERIFY(!part<QWidget>("motionRecoveryLine")->isVisible());
    QFile::remove(file); // as the hosts do
    motion_->models["m"] = {true, 0, 18.5, 0, "motion"};
    motion_->running = false;
    Q_EMIT motion_->finished({"m", {}, {}, {}, {}, 8192, 37});
    QVERIFY(!part<QWidget>("motionRecoveryLine")->isVisible());
    run()->click();
    QCOMPARE(motion_->requests.last().resumeFile, QString());
  }

  void theSliderShowsTimes() {
    addModel("m", "Model", {true, 2, 6, 3, "intensity"});
    addModel("still", "Still", {});
    panel_->setModelId("still");
    QVERIFY(part<QLabel>("motionAboutModel")->text().contains("does not move"));
    QVERIFY(!part<QToolButton>("motionPlay")->isEnabled());
    panel_->setModelId("m");
    auto* value = part<QDoubleSpinBox>("motionTimeValue");
    QCOMPARE(value->value(), 3.0);
    QCOMPARE(value->minimum(), 2.0);
    QCOMPARE(value->maximum(), 6.0);
    part<QSlider>("motionTimeSlider")->setValue(4500);
    QCOMPARE(motion_->times, QVector<double>{4.5});
    Q_EMIT motion_->timeChanged("m", 5.25); // by the sequence browser
    QCOMPARE(value->value(), 5.25);
    QCOMPARE(motion_->times.size(), 1); // and not sent back
  }

  void plays() {
    addModel("m", "Model", {true, 0, 0.3, 0, "motion"});
    panel_->setModelId("m");
    part<QToolButton>("motionPlay")->click();
    const auto wrapped = [&] {
      for (int n = 1; n < motion_->times.size(); ++n)
        if (motion_->times[n] < motion_->times[n - 1]) return true;
      return false;
    };
    TRY_VERIFY(wrapped());
    for (const double time : std::as_const(motion_->times))
      QVERIFY(time >= 0 && time <= 0.3);
    part<QToolButton>("motionPlay")->click();
    QVERIFY(!part<QToolButton>("motionPlay")->isChecked());
  }
};

QTEST_MAIN(MotionPanelTest)
#include "MotionPanelTest.moc"
