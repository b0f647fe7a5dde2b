// Dynamic scans in the desktop app, from the file to the slider.
#include "AppWindowTest.h"
#include "SyntheticImages.h"

#include "Core/Motion/TimeSeries.h"
#include "Core/Render/Render.h"
#include "IO/DynamicModelFile.h"
#include "IO/RecoveredFit.h"
#include "IO/TimeSeriesIO.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"
#include "Text/SegmentedModel.h"
#include "Widgets/App/AppMotionHost.h"
#include "Widgets/App/Files.h"
#include "Widgets/MotionPanel.h"

#include <QDockWidget>

#include <fstream>

using namespace innergs;
using namespace apptest;

class AppMotionTest : public AppWindowTest {
  Q_OBJECT

  QString writeSeries(const char* name, int frames = 6) {
    QString path = sandbox_->path(name);
    writeTimeSeries(test::movingBlob(frames), app::pathOf(path));
    return path;
  }
  /// Opens a dynamic scan; returns its ID.
  QString openScan(const QString& path) {
    open({path});
    [&] { TRY_COMPARE(host().document().volumes().size(), std::size_t{1}); }();
    return host().document().volumes().front()->id;
  }
  static ui::MotionRequest requestOf(const QString& scan, DynamicKind kind) {
    ui::MotionRequest request;
    request.seriesId = scan;
    request.settings.kind = kind;
    return request;
  }
  app::AppMotionHost& motion() { return window_->host()->motionHost(); }
  /// Waits for the end of a run, which must be a success.
  static ui::MotionReport reportOf(const QSignalSpy& finished, const QSignalSpy& failed) {
    [&] {
      TRY_VERIFY(finished.size() + failed.size() > 0);
      QVERIFY2(failed.isEmpty(), failed.isEmpty() ? "" : qPrintable(failed[0][0].toString()));
    }();
    return finished.isEmpty() ? ui::MotionReport() : finished[0][0].value<ui::MotionReport>();
  }

private Q_SLOTS:
  void init() { AppWindowTest::init(); }
  void cleanup() { AppWindowTest::cleanup(); }

  void fromTheFileToTheSlider() {
    openScan(writeSeries("moving.nii.gz"));
    auto* dock = window_->findChild<QDockWidget*>("motionDock");
    TRY_VERIFY(!dock->visibleRegion().isEmpty()); // a 4D file leads here
    window_->motion()->findChild<QComboBox*>("motionKind")->setCurrentIndex(1);
    QSignalSpy finished(&motion(), &ui::MotionHost::finished), failed(&motion(), &ui::MotionHost::failed),
        shown(&motion(), &app::AppMotionHost::frameShown);
    window_->motion()->findChild<QPushButton*>("motionRun")->click();
    QVERIFY(motion().isRunning());
    const ui::MotionReport report = reportOf(finished, failed);
    QCOMPARE(report.quality.size(), 3);
    QVERIFY(report.quality[0].psnr > 20);
    const QString id = report.modelId;
    QVERIFY(host().document().model(id)->dynamic);

    // Any time is a volume in the views, and what the model is elsewhere.
    TRY_VERIFY(shown.size() > 0);
    const auto brightest = [&] {
      const auto& volume = *window_->state()->volume()->volume;
      return (std::max_element(volume.voxels.begin(), volume.voxels.end()) - volume.voxels.begin()) % 16;
    };
    TRY_COMPARE(brightest(), std::ptrdiff_t{5});
    motion().setTime(id, 2.25);                  // between two frames
    TRY_COMPARE(brightest(), std::ptrdiff_t{9}); // 5 + 0.8·4.5 = 8.6
    QCOMPARE(motion().motionInfo(id).now, 2.25);
    QCOMPARE(host().document().volumes().size(), std::size_t{2}); // one volume for all times

    // It learns segments at that time, and its file keeps them.
    const SegmentedModel segmented = host().document().model(id)->model->GetSegmented();
    Volume bright = render(*segmented.field, segmented.field->region());
    const float most = *std::max_element(bright.voxels.begin(), bright.voxels.end());
    for (float& value : bright.voxels)
      value = value > most / 2;
    FeatureTraining training;
    training.iterations = 20;
    const FeatureModel features =
        trainFrom(segmented, NamedLabels{labelmapOf(bright), {{1, "blob"}}}, training);
    QCOMPARE(features.time, 2.25);
    QCOMPARE(host().setFeatures(id, std::make_shared<const FeatureModel>(features)), QString());
    const auto taught = host().document().model(id);
    QVERIFY(taught->dynamic && !taught->saved);
    QCOMPARE(taught->model->GetNumberOfSegments(), 1);
    QCOMPARE(taught->model->GetSegmented().time, 2.25);

    const QString model = sandbox_->path("m.innergs"), frames = sandbox_->path("f.seq.nrrd");
    QCOMPARE(host().saveModel(id, model), QString());
    QVERIFY(isDynamicModel(app::pathOf(model)));
    QCOMPARE(motion().saveFrames(id, 4, frames), QString());
    QCOMPARE(readTimeSeries(app::pathOf(frames)).size(), std::int64_t{11});
    QVERIFY(!motion().saveFrames(id, 0, sandbox_->path("moving.nii.gz")).isEmpty()); // the scan itself

    // A saved model opens as what it is.
    open({model});
    TRY_COMPARE(host().document().models().size(), std::size_t{2});
    QVERIFY(host().document().models().back()->dynamic);
    QCOMPARE(QString::fromStdString(host().document().models().back()->dynamic->GetSegmentName(0)),
             QString("blob"));
  }

  /// By events: at the first preview the slider moves, then the fit is cancelled.
  void theModelSoFarIsShownAndGoesWithACancel() {
    ui::MotionRequest request = requestOf(openScan(writeSeries("moving.nii.gz", 12)), DynamicKind::Motion);
    request.settings.rounds = 10000; // until it is cancelled
    QSignalSpy previewed(&motion(), &ui::MotionHost::previewed),
        cancelled(&motion(), &ui::MotionHost::cancelled), shown(&motion(), &app::AppMotionHost::frameShown);
    QVERIFY(motion().start(request));
    TRY_VERIFY(!previewed.isEmpty() && !shown.isEmpty());
    QVERIFY(motion().previewInfo().known);
    QCOMPARE(motion().previewInfo().last, 5.5);
    const int before = shown.size();
    motion().setPreviewTime(2.25);
    TRY_VERIFY(shown.size() > before);
    QCOMPARE(host().document().volumes().size(), std::size_t{2});
    QVERIFY(host().document().models().empty()); // not before it is complete
    motion().cancel();
    TRY_COMPARE(cancelled.size(), 1);
    TRY_COMPARE(host().document().volumes().size(), std::size_t{1});
    QVERIFY(!motion().previewInfo().known);
  }

  /// Cancelled, then closed: each time it goes on from where it stood, as the panel offers.
  void goesOnAfterACancelAndAfterClosing() {
    const QString scan = writeSeries("moving.nii.gz", 12);
    ui::MotionRequest request = requestOf(openScan(scan), DynamicKind::Motion);
    request.settings.rounds = 10000; // until it is stopped
    const auto kept = [&] { return recoveredFits(host().recoveryFolder().toStdU16String()); };
    {
      QSignalSpy previewed(&motion(), &ui::MotionHost::previewed),
          cancelled(&motion(), &ui::MotionHost::cancelled);
      QVERIFY(motion().start(request));
      TRY_VERIFY(!previewed.isEmpty());
      motion().cancel();
      TRY_COMPARE(cancelled.size(), 1);
    }
    QCOMPARE(kept().size(), std::size_t(1));
    const int reached = kept()[0].iteration;
    QVERIFY(reached > 0 && kept()[0].iterations == 120000);

    const auto start = [&] {
      QSignalSpy previewed(&motion(), &ui::MotionHost::previewed), failed(&motion(), &ui::MotionHost::failed);
      auto* goOn = window_->findChild<QPushButton*>("motionGoOn");
      QVERIFY(goOn->isVisible());
      goOn->click();
      window_->motion()->findChild<QPushButton*>("motionRun")->click();
      TRY_VERIFY(!previewed.isEmpty() || !failed.isEmpty());
      QVERIFY2(failed.isEmpty(), failed.isEmpty() ? "" : qPrintable(failed[0][0].toString()));
    };
    start();
    stopAndClose();
    QCOMPARE(kept().size(), std::size_t(1)); // the newer state alone
    QVERIFY(kept()[0].iteration > reached);

    window_ = std::make_unique<app::MainWindow>();
    window_->show();
    open({scan});
    start();
    motion().cancel();
    TRY_VERIFY(!motion().isRunning());
    QCOMPARE(kept().size(), std::size_t(1));
  }

  void aFolderOfFramesIsAMovingScan() {
    const QString file = writeSeries("all.nii.gz");
    const TimeSeries series = readTimeSeries(app::pathOf(file));
    const std::filesystem::path folder = app::pathOf(sandbox_->path("frames"));
    std::filesystem::create_directory(folder);
    std::ofstream times(folder / "times.txt");
    for (std::int64_t f = 0; f < series.size(); ++f) {
      writeVolume({series.geometry, series.frames[f]}, folder / ("f" + std::to_string(8 + f) + ".nii.gz"));
      times << f * f << "\n";
    }
    times.close();
    openScan(sandbox_->path("frames"));
    const auto scan = host().document().volumes().front();
    QCOMPARE(scan->frames.count, 6);
    const ui::SeriesInfo info = motion().seriesInfo(scan->id);
    QCOMPARE(info.frames, 6);
    QVERIFY(info.timed);
    QSignalSpy finished(&motion(), &ui::MotionHost::finished), failed(&motion(), &ui::MotionHost::failed);
    ui::MotionRequest request = requestOf(scan->id, DynamicKind::Intensity);
    request.evaluateQuality = false;
    QVERIFY(motion().start(request));
    QCOMPARE(motion().motionInfo(reportOf(finished, failed).modelId).last, 25.0);
  }

  void slicesAreTakenAtTheTimesOfAChosenFile() {
    ui::MotionRequest request = requestOf(openScan(writeSeries("bold.nii.gz", 8)), DynamicKind::Intensity);
    request.evaluateQuality = false;
    const auto write = [&](const char* name, const char* text) {
      request.sliceTimesFile = sandbox_->path(name);
      std::ofstream(app::pathOf(request.sliceTimesFile)) << text;
    };
    const auto changes = [&] {
      QSignalSpy finished(&motion(), &ui::MotionHost::finished), failed(&motion(), &ui::MotionHost::failed);
      motion().start(request);
      [&] { TRY_VERIFY(finished.size() + failed.size() > 0); }();
      if (finished.isEmpty()) return std::vector<float>();
      const QString id = finished[0][0].value<ui::MotionReport>().modelId;
      return host().document().model(id)->dynamic->GetField()->changes;
    };
    const std::vector<float> atOnce = changes();
    QVERIFY(!atOnce.empty());
    write("task.json", R"({"SliceTiming": [0, 0.3, 0.1, 0.4, 0.2]})");
    const std::vector<float> timed = changes();
    QVERIFY(!timed.empty());
    QVERIFY(timed != atOnce);
    write("task.txt", "0 0.3 0.1 0.4 0.2");
    QVERIFY(changes() == timed);
    write("bad.json", R"({"SliceTiming": [0, 0.3]})");
    QSignalSpy failed(&motion(), &ui::MotionHost::failed);
    QVERIFY(changes().empty());
    QVERIFY2(failed[0][0].toString().contains("2 slice times for 5 slices"),
             qPrintable(failed[0][0].toString()));
  }

  void cancelAndBadScans() {
    ui::MotionRequest request;
    request.seriesId = openScan(writeSeries("moving.nii.gz", 12));
    QSignalSpy cancelled(&motion(), &ui::MotionHost::cancelled), failed(&motion(), &ui::MotionHost::failed);
    QVERIFY(motion().start(request));
    QVERIFY(!motion().start(request)); // one at a time
    QCOMPARE(failed.size(), 1);
    motion().cancel();
    TRY_COMPARE(cancelled.size(), 1);
    QVERIFY(host().document().models().empty());
    request.rate = -1;
    QVERIFY(motion().start(request));
    TRY_COMPARE(failed.size(), 2);
    QVERIFY(failed[1][0].toString().contains("above 0"));
    request.seriesId = "none";
    QVERIFY(!motion().start(request));
    QVERIFY(failed[2][0].toString().contains("no dynamic scan"));
  }
};

QTEST_MAIN(AppMotionTest)
#include "AppMotionTest.moc"
