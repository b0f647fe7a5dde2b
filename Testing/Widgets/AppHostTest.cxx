// The desktop app's host: reconstructions on a thread, estimates, cancel; without a window.
#include "AppFixture.h"
#include "ThreadShortage.h"

#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/ReconstructionJob.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/Runner.h"

#include <vtkDataArray.h>
#include <vtkPointData.h>
#include <vtkTable.h>

#include <QDir>
#include <QFile>
#include <QSignalSpy>
#include <QTest>

#include <cmath>
#include <limits>
#include <memory>
#include <new>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;

class AppHostTest : public HostTest {
  Q_OBJECT
  /// Of the ball's voxels, those with I from `first` to `last`.
  QString writeMask(const QString& name, std::int64_t first, std::int64_t last) {
    Volume mask = ball({24, 24, 10}, {1.5, 1.5, 4});
    for (std::size_t v = 0; v < mask.voxels.size(); ++v) {
      const auto i = static_cast<std::int64_t>(v % 24);
      mask.voxels[v] = i >= first && i <= last ? 1.f : 0.f;
    }
    QString path = sandbox_->path(name);
    writeVolume(mask, path.toStdString());
    return path;
  }
  /// The sentence with which a run ends that starts but fails.
  QString failureOf(const ui::Request& request) {
    QSignalSpy failed(host_.get(), &AppHost::failed);
    [&] {
      QVERIFY(host_->start(request));
      QVERIFY(failed.wait(kPatience));
    }();
    return failed.isEmpty() ? QString() : failed.first().first().toString();
  }
  /// The sentence with which it is refused.
  QString failureOfStart(const ui::Request& request) {
    QSignalSpy failed(host_.get(), &AppHost::failed);
    return host_->start(request) || failed.isEmpty() ? QString() : failed.first().first().toString();
  }

private Q_SLOTS:
  void estimatesQuickly() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {128, 128, 40}));
    ui::Request request = apptest::request(id);
    request.evaluateQuality = true;
    ui::Estimate estimate = host_->estimate(request);
    QCOMPARE(estimate.seconds, 0.0); // the slow parts are left to a thread
    QVERIFY(estimate.refusal.isEmpty());
    QVERIFY(estimate.memory > 1 << 20);
    // Device and time arrive a moment later.
    TRY_VERIFY(host_->estimate(request).seconds > 0);
    estimate = host_->estimate(request);
    QVERIFY(estimate.reason.contains("CPU"));
    request.inputs.clear();
    QVERIFY(!host_->estimate(request).refusal.isEmpty());
    request = apptest::request(id);
    request.settings.gaussians = -5;
    QVERIFY(!host_->estimate(request).refusal.isEmpty());
  }

  // As the engine's own default grid, and that of 3D Slicer's panel.
  void coversAllSlabsAtAnySpacing() {
    app::ReconstructionTask task;
    for (const double slab : {0, 1}) {
      Volume part = ball({24, 24, 10}, {1.5, 1.5, 4});
      part.geometry.origin[2] += slab * 10 * 4;
      task.inputs.push_back(app::makeItem(std::move(part), "slab"));
      task.request.inputs << ui::InputChoice{};
    }
    task.request.grid = ui::OutputGrid::Spacing;
    task.request.spacing = 2;
    QCOMPARE(app::makeInput(task, false).outputGrid->size, (std::array<std::int64_t, 3>{18, 18, 40}));
    task.request.spacing = 0;
    QVERIFY_EXCEPTION_THROWN(app::makeInput(task, false), Error);
  }

  // With the job's own message; the job rejects it as well.
  void refusesBeforehandWhatTheMemoryCannotHold() {
    if (availableMemory() == 0) QSKIP("This system does not say how much memory is available.");
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    ui::Request request = apptest::request(id);
    request.grid = ui::OutputGrid::Spacing;
    request.spacing = 0.002; // some 10¹² voxels
    const ui::Estimate estimate = host_->estimate(request);
    QVERIFY2(estimate.refusal.startsWith("The reconstruction needs about "), qPrintable(estimate.refusal));
    QVERIFY(estimate.memory > estimate.available);
    const QString sentence = failureOf(request); // the available memory changes
    QCOMPARE(sentence.section(", but only ", 0, 0), estimate.refusal.section(", but only ", 0, 0));
  }

  // A time measured during a reconstruction is not kept.
  void estimatesAnewAfterARun() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {64, 64, 20}));
    const ui::Request request = apptest::request(id);
    QSignalSpy changed(host_.get(), &AppHost::estimateChanged);
    host_->estimate(request);
    const ui::Report report = reconstructAndWait(*host_, request);
    QVERIFY(!report.volumeId.isEmpty());
    TRY_VERIFY(!changed.isEmpty());
    QCOMPARE(host_->estimate(request).seconds, 0.0); // requested again
    TRY_VERIFY(host_->estimate(request).seconds > 0);
  }

  // Nothing thrown on a thread ends the program, and waiting tasks continue.
  void survivesWorkThatThrows() {
    QSignalSpy logged(host_.get(), &AppHost::logged);
    app::Background& thread = host_->background();
    thread.run("First", []() -> std::function<void()> { throw std::bad_alloc(); });
    thread.runAndWait("Second", [] { throw 7; });
    bool done = false;
    thread.runAndWait("Third", [&] { done = true; });
    QVERIFY(done);
    QVERIFY(!thread.isBusy());
    QCOMPARE(logged.size(), 2);
    QVERIFY(logged[0].first().toString().startsWith("There is not enough memory: "));
    QVERIFY(logged[1].first().toString().startsWith("Unexpected failure: "));
  }

  void tellsWhenNoThreadCanBeStarted() {
    if (!test::ThreadShortage::known()) QSKIP("This system's threads cannot be refused here.");
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    {
      const test::ThreadShortage shortage(0);
      const QString sentence = failureOf(apptest::request(id));
      QVERIFY2(sentence.contains("another thread"), qPrintable(sentence));
    }
    QVERIFY(!host_->isRunning());
    QVERIFY(!reconstructAndWait(*host_, apptest::request(id)).volumeId.isEmpty()); // once there are some
  }

  void worksOnTheMainThreadWithoutAnother() {
    if (!test::ThreadShortage::known()) QSKIP("This system's threads cannot be refused here.");
    const test::ThreadShortage shortage(0);
    app::Background background;
    bool done = false, after = false;
    background.runAndWait("First", [&] { done = true; });
    QVERIFY(done);
    background.run("Second", [&] { return [&] { after = true; }; });
    TRY_VERIFY(after);
    QVERIFY(!background.isBusy());
  }

  /// The images of a sweep lie where they were tracked, not evenly apart.
  void reconstructsATrackedSweepInPlace() {
    const QString id = openAndWait(*host_, writeSweep(*sandbox_, "sweep.mha", true));
    QVERIFY(host_->volumeInfo(id).hasPoses);
    QVERIFY(host_->document().volume(id)->note.contains("puts each where it lies"));
    ui::Request request = apptest::request(id);
    request.settings.iterations = 20;
    request.evaluateQuality = false;
    QCOMPARE(host_->estimate(request).refusal, QString());
    const ui::Report report = reconstructAndWait(*host_, request);
    const auto made = host_->document().volume(report.volumeId);
    QVERIFY(made);
    const Affine3 toWorld = made->volume->geometry.indexToWorld();
    const auto& size = made->volume->geometry.size;
    Vec3 centre{0, 0, 0};
    double mass = 0;
    for (std::size_t v = 0; v < made->volume->voxels.size(); ++v) {
      const double value = made->volume->voxels[v];
      if (!(value > 20)) continue;
      const auto n = static_cast<std::int64_t>(v);
      centre = centre + value * toWorld({double(n % size[0]), double(n / size[0] % size[1]),
                                         double(n / (size[0] * size[1]))});
      mass += value;
    }
    QVERIFY(mass > 0);
    QVERIFY(norm((1 / mass) * centre - Vec3{-3, -10, 35}) < 0.5); // LPS
    request.evaluateQuality = true;
    const ui::Report judged = reconstructAndWait(*host_, request);
    QVERIFY(!judged.volumeId.isEmpty() && judged.quality.isEmpty());
    QVERIFY(judged.warnings.join(' ').contains("hold out slices instead"));
    request.inputs[0].sliceAxis = 0;
    QVERIFY(host_->estimate(request).refusal.contains("place of its own"));
  }

  /// A scan without a grid is no mask, reference or labelmap, and no file of a volume holds it.
  void usesASweepForNothingElse() {
    const QString sweep = openAndWait(*host_, writeSweep(*sandbox_, "sweep.mha", true));
    const QString scan = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    const QString says = "lie on no grid";
    ui::Request request = apptest::request(scan);
    request.maskId = sweep;
    QVERIFY(host_->estimate(request).refusal.contains(says));
    request = apptest::request(scan);
    request.inputs[0].maskId = sweep;
    QVERIFY(host_->estimate(request).refusal.contains(says));
    request = apptest::request(scan);
    request.grid = ui::OutputGrid::Reference;
    request.referenceId = sweep;
    QVERIFY(host_->estimate(request).refusal.contains(says));
    QVERIFY(host_->save(sweep, sandbox_->path("sweep.nii.gz")).contains(says));
    QVERIFY(!QFile::exists(sandbox_->path("sweep.nii.gz")));
  }

  void aSweepNeedsItsCalibration() {
    const QString id = openAndWait(*host_, writeSweep(*sandbox_, "sweep.mha", false));
    QVERIFY(host_->document().volume(id)->unplaced.contains("ImageToProbe"));
    const ui::Request request = apptest::request(id);
    QVERIFY(host_->estimate(request).refusal.contains("ImageToProbe"));
    QVERIFY(failureOfStart(request).contains("ImageToProbe"));
    QSignalSpy opened(host_.get(), &AppHost::opened), failed(host_.get(), &AppHost::openFailed);
    host_->calibrate(id, sandbox_->path("sweep.mha")); // is none
    QVERIFY(failed.wait(kPatience));
    QVERIFY(host_->document().volume(id)->poses.empty());
    host_->calibrate(id, sweepCalibration(*sandbox_));
    QVERIFY(opened.wait(kPatience));
    QCOMPARE(opened.last().first().toString(), id);
    QCOMPARE(host_->document().volume(id)->poses.size(), std::size_t(33));
    QCOMPARE(host_->estimate(request).refusal, QString());
  }

  void slicesThatMovedAreWritten() {
    const QString axial = openAndWait(*host_, writeBall(*sandbox_, "axial.nii.gz"));
    const QString sagittal =
        openAndWait(*host_, writeBall(*sandbox_, "sagittal.nii.gz", {10, 24, 24}, {4, 1.5, 1.5}));
    QVERIFY(!host_->hasResult());
    ui::Request request = apptest::request(axial);
    const ui::Report alone = reconstructAndWait(*host_, request);
    QVERIFY(host_->hasResult() && !host_->sliceTable());
    request.inputs.push_back({sagittal});
    request.settings.sliceMotion = SliceMotionKind::On;
    const ui::Report report = reconstructAndWait(*host_, request);
    QVERIFY2(
        report.warnings.join(' ').contains("The slices were moved one by one, half of them by more than"),
        qPrintable(report.warnings.join(' ')));
    QVERIFY(host_->sliceTable());
    QCOMPARE(host_->sliceTable()->GetNumberOfRows(), vtkIdType(20));
    QString error;
    const QString folder = sandbox_->path("poses");
    QVERIFY(host_->createSliceTransforms(folder, &error).contains("20"));
    QCOMPARE(error, QString());
    QCOMPARE(QDir(folder).entryList({"scan-*-slice-*.tfm"}).size(), 20);
    const QString file = sandbox_->path("slices.tsv");
    QCOMPARE(host_->saveSliceTable(file), QString());
    QFile table(file);
    QVERIFY(table.open(QIODevice::ReadOnly));
    QVERIFY(table.readLine().startsWith("scan\tslice\tweight\t"));
    QCOMPARE(table.readAll().count('\n'), 20);
    QVERIFY(host_->createSliceTransforms(file, &error).isEmpty()); // a file is no folder
    QVERIFY2(error.contains("slices.tsv"), qPrintable(error));
    host_->document().remove(report.modelId);
    QVERIFY(!host_->hasResult() && !host_->sliceTable());
  }

  void everyScanMayHaveAMaskOfItsOwn() {
    const QString axial = openAndWait(*host_, writeBall(*sandbox_, "axial.nii.gz"));
    const QString sagittal =
        openAndWait(*host_, writeBall(*sandbox_, "sagittal.nii.gz", {10, 24, 24}, {4, 1.5, 1.5}));
    const QString left = openAndWait(*host_, writeMask("left.nii.gz", 12, 23));
    const QString right = openAndWait(*host_, writeMask("right.nii.gz", 0, 11));
    const QString empty = openAndWait(*host_, writeMask("empty.nii.gz", 0, -1));
    ui::Request request = apptest::request(axial);
    request.inputs.push_back({sagittal});
    request.settings.align = false;
    request.settings.sliceMotion = SliceMotionKind::Off;
    request.inputs[0].maskId = left;
    QVERIFY(host_->estimate(request).refusal.startsWith("'sagittal' has no mask"));
    request.maskId = right; // of the scans without one
    const ui::Report both = reconstructAndWait(*host_, request);
    const auto masksOf = [this](const ui::Report& report) {
      return QString::fromStdString(host_->document().model(report.modelId)->notes.at("Mask"));
    };
    QCOMPARE(masksOf(both), QString("left; right"));
    request.inputs[0].maskId.clear(); // one for both
    const ui::Report one = reconstructAndWait(*host_, request);
    QCOMPARE(masksOf(one), QString("right"));
    // The results are as wide as their masks together.
    QVERIFY(host_->volumeInfo(both.volumeId).dimensions[0] >
            host_->volumeInfo(one.volumeId).dimensions[0] + 5);
    request.inputs[1].maskId = empty;
    const QString sentence = failureOf(request);
    QVERIFY2(sentence.startsWith("The mask of sagittal holds no centre of its finite voxels"),
             qPrintable(sentence));
  }

  void reconstructsTwiceIntoNewItems() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    const auto input = host_->document().volume(id)->volume;
    QSignalSpy progress(host_.get(), &AppHost::progressed);
    const ui::Report first = reconstructAndWait(*host_, apptest::request(id));
    QVERIFY(!progress.isEmpty());
    double last = 0;
    for (const auto& arguments : progress) {
      const double fraction = arguments.first().value<Progress>().fraction;
      QVERIFY(fraction >= last && fraction <= 1);
      last = fraction;
    }
    QCOMPARE(host_->volumeInfo(first.volumeId).name, QString("ball reconstructed"));
    QCOMPARE(host_->volumeInfo(first.volumeId).spacing[2], 1.5); // isotropic at the finest spacing
    QVERIFY(first.trainingPsnr > 20);
    QVERIFY(first.settings.contains("gaussians=300"));
    QVERIFY(host_->modelInfo(first.modelId).gaussians > 100);
    QCOMPARE(host_->modelInfo(first.modelId).origin, QString("ball"));
    QVERIFY(!host_->modelInfo(first.modelId).saved);
    QVERIFY(host_->document().hasUnsaved());
    // Window and level are kept: result and input share one.
    QVERIFY(host_->document().volume(first.volumeId)->window == host_->document().volume(id)->window);
    const ui::Report second = reconstructAndWait(*host_, apptest::request(id));
    QCOMPARE(host_->volumeInfo(second.volumeId).name, QString("ball reconstructed (2)"));
    QVERIFY(second.volumeId != first.volumeId && second.modelId != first.modelId);
    // Same input, settings and seed: same voxels. The input is untouched.
    QVERIFY(host_->document().volume(second.volumeId)->volume->voxels ==
            host_->document().volume(first.volumeId)->volume->voxels);
    QVERIFY(host_->document().volume(id)->volume == input);
    // On request over an existing one.
    ui::Request over = apptest::request(id);
    over.outputVolumeId = first.volumeId;
    over.outputModelId = first.modelId;
    over.grid = ui::OutputGrid::Spacing;
    over.spacing = 3;
    const ui::Report third = reconstructAndWait(*host_, over);
    QCOMPARE(third.volumeId, first.volumeId);
    QCOMPARE(host_->volumeInfo(first.volumeId).spacing[0], 3.0);
    QCOMPARE(int(host_->document().volumes().size()), 3);
  }

  void judgesTheQualityWhenAsked() {
    const QString id =
        openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {24, 24, 24}, {1.5, 1.5, 1.5}));
    ui::Request request = apptest::request(id);
    request.evaluateQuality = true;
    request.heldOutFraction = 0.1;
    const ui::Report report = reconstructAndWait(*host_, request);
    QVERIFY(report.quality.size() >= 4);
    QVERIFY(!report.qualitySamples.isEmpty());
    QVERIFY(std::isfinite(report.heldOutPsnr));
    QCOMPARE(report.heldOutSlices, 2);
    QCOMPARE(int(report.judging), int(Judging::Done));
    for (const ui::QualityRow& row : report.quality)
      QVERIFY(row.psnr > 10 && row.ssim <= 1);
    // The delivered model is fitted to all slices, however the quality is measured.
    const ui::Report plain = reconstructAndWait(*host_, apptest::request(id));
    QCOMPARE(int(plain.judging), int(Judging::NotAsked));
    QVERIFY(host_->document().volume(plain.volumeId)->volume->voxels ==
            host_->document().volume(report.volumeId)->volume->voxels);
    QCOMPARE(plain.trainingPsnr, report.trainingPsnr);
  }

  void theUncertaintyIsAVolumeOfTheDocument() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {36, 36, 30}, {1.5, 1.5, 2}));
    ui::Request request = apptest::request(id);
    const ui::Estimate without = host_->estimate(request);
    request.estimateUncertainty = true;
    QVERIFY(host_->estimate(request).memory > without.memory);
    const ui::Report report = reconstructAndWait(*host_, request);
    QVERIFY2(!report.uncertaintyId.isEmpty(), qPrintable(report.warnings.join(' ')));
    QVERIFY(report.uncertainty.contains("90 % intervals"));
    const auto item = host_->document().volume(report.uncertaintyId);
    QCOMPARE(item->name, QString("ball standard deviation"));
    QVERIFY(item->volume->geometry == host_->document().volume(report.volumeId)->volume->geometry);
    QVERIFY(item->range[0] > 0);
    QCOMPARE(item->window->lower, 0.0);
    QVERIFY(item->window->upper > item->range[0] && item->window->upper <= item->range[1]);
    QVERIFY(host_->document().unsaved().contains(report.uncertaintyId));
    const auto measured = host_->document().volumes().back(); // a labelmap of where some slice measured
    QCOMPARE(measured->name, QString("ball measured"));
    QCOMPARE(measured->volume->geometry.size, item->volume->geometry.size);
    vtkDataArray* said = item->image->GetPointData()->GetArray("Measured");
    for (std::size_t v = 0; v < measured->volume->voxels.size(); ++v)
      QCOMPARE(measured->volume->voxels[v], float(said->GetComponent(vtkIdType(v), 0)));
    QCOMPARE(host_->save(measured->id, sandbox_->path("measured.nii.gz")), QString());
    const QString file = sandbox_->path("deviation.nii.gz");
    QCOMPARE(host_->save(report.uncertaintyId, file), QString());
    QVERIFY(readVolume(file.toStdString()).voxels == item->volume->voxels);
    const auto known = host_->uncertaintyOf(report.modelId);
    QVERIFY(known && known->image == item->image);
    QVERIFY(known->image->GetPointData()->GetArray("Measured"));
    host_->document().remove(report.uncertaintyId);
    QVERIFY(!host_->uncertaintyOf(report.modelId));
  }

  void cancelledWhileJudgingKeepsTheFit() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    ui::Request request = apptest::request(id);
    request.evaluateQuality = true;
    request.qualityGap = 2;
    request.settings.iterations =
        1000; // of the second fit as well, which has hardly begun when its progress arrives
    QSignalSpy finished(host_.get(), &AppHost::finished), cancelled(host_.get(), &AppHost::cancelled);
    connect(host_.get(), &AppHost::progressed, host_.get(), [&](const Progress& progress) {
      if (progress.phase == Phase::Judging) host_->cancel();
    });
    QVERIFY(host_->start(request));
    QVERIFY(finished.wait(kPatience));
    QVERIFY(cancelled.isEmpty());
    const auto report = finished.first().first().value<ui::Report>();
    QCOMPARE(int(report.judging), int(Judging::Stopped));
    QVERIFY(report.quality.isEmpty());
    QVERIFY(report.warnings.last().contains("complete"));
    QVERIFY(host_->modelInfo(report.modelId).gaussians > 100);
  }

  void cancelsAtAnyMoment() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {48, 48, 16}));
    QSignalSpy cancelled(host_.get(), &AppHost::cancelled), finished(host_.get(), &AppHost::finished),
        progress(host_.get(), &AppHost::progressed);
    for (const int reports : {0, 1, 20}) {
      cancelled.clear();
      progress.clear();
      QVERIFY(host_->start(apptest::request(id, true)));
      QVERIFY(host_->isRunning());
      TRY_VERIFY(progress.count() >= reports);
      host_->cancel();
      QVERIFY(cancelled.isEmpty()); // it does not wait for anything
      QVERIFY(cancelled.wait(kPatience));
      QVERIFY(!host_->isRunning());
    }
    QVERIFY(finished.isEmpty());
    QCOMPARE(int(host_->document().volumes().size()), 1);
    QVERIFY(!reconstructAndWait(*host_, apptest::request(id)).volumeId.isEmpty()); // and again
  }

  void refusesWithASentence() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    QSignalSpy failed(host_.get(), &AppHost::failed);
    const auto refused = [&](const ui::Request& request, const QString& words) {
      failed.clear();
      const bool started = host_->start(request);
      const QString sentence = failed.isEmpty() ? QString() : failed.first().first().toString();
      return !started && sentence.contains(words) ? QString() : "not refused well: " + sentence;
    };
    ui::Request request = apptest::request(id);
    request.inputs.clear();
    QCOMPARE(refused(request, "no input"), QString());
    request = apptest::request("gone");
    QCOMPARE(refused(request, "no longer open"), QString());
    request = apptest::request(id);
    request.outputVolumeId = id;
    QCOMPARE(refused(request, "inputs are never changed"), QString());
    request = apptest::request(id);
    request.grid = ui::OutputGrid::Reference;
    QCOMPARE(refused(request, "reference"), QString());
    request = apptest::request(id);
    request.settings.device = "abacus";
    QCOMPARE(refused(request, "abacus"), QString());
    QVERIFY(host_->start(apptest::request(id, true)));
    QCOMPARE(refused(apptest::request(id), "running"), QString());
    host_->cancel();
    QSignalSpy cancelled(host_.get(), &AppHost::cancelled);
    QVERIFY(cancelled.wait(kPatience));
  }

  void failsOnTheThreadWithASentence() {
    // Every voxel is NaN: detected when the fit is prepared.
    Volume volume = ball({8, 8, 8}, {1, 1, 1});
    std::fill(volume.voxels.begin(), volume.voxels.end(), std::numeric_limits<float>::quiet_NaN());
    const QString id = host_->document().add(app::makeItem(std::move(volume), "nothing"));
    QVERIFY(failureOf(apptest::request(id)).contains("finite"));
    QVERIFY(!host_->isRunning());
  }

  void volumeClosedWhileItIsReconstructed() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    QSignalSpy finished(host_.get(), &AppHost::finished);
    ui::Request request = apptest::request(id);
    QVERIFY(host_->start(request));
    host_->document().remove(id);
    QVERIFY(finished.wait(kPatience));
    QCOMPARE(int(host_->document().volumes().size()), 1);
  }

  void deletedWhileRunning() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {48, 48, 16}));
    QSignalSpy progress(host_.get(), &AppHost::progressed);
    QVERIFY(host_->start(apptest::request(id, true))); // takes minutes
    QVERIFY(progress.wait(kPatience));
    host_.reset();
  }
};

QTEST_GUILESS_MAIN(AppHostTest)
#include "AppHostTest.moc"
