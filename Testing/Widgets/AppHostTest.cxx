// The desktop app's host: files, reconstructions on a thread, cancel, models; without a window.
#include "AppFixture.h"

#include "IO/ModelFile.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"

#include <QElapsedTimer>
#include <QSignalSpy>
#include <QTest>
#include <QTimer>

#include <vtkImageData.h>
#include <vtkNew.h>

#include <cmath>
#include <limits>
#include <memory>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;

class AppHostTest : public QObject {
  Q_OBJECT
private:
  std::unique_ptr<Sandbox> sandbox_;
  std::unique_ptr<AppHost> host_;

  ui::Report reconstruct(const ui::Request& request) {
    QSignalSpy finished(host_.get(), &AppHost::finished);
    if (!host_->start(request)) return {};
    finished.wait(60000);
    return finished.isEmpty() ? ui::Report() : finished.first().first().value<ui::Report>();
  }

private Q_SLOTS:
  void init() {
    sandbox_ = std::make_unique<Sandbox>();
    host_ = std::make_unique<AppHost>();
  }
  void cleanup() {
    host_.reset();
    sandbox_.reset();
  }

  void opensAVolumeWithItsGeometry() {
    const QString id =
        openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {24, 20, 10}, {1.5, 1.5, 4}, true));
    QVERIFY(!id.isEmpty());
    const ui::VolumeInfo info = host_->volumeInfo(id);
    QCOMPARE(info.name, QString("ball"));
    QCOMPARE(info.dimensions[1], 20);
    QVERIFY(std::abs(info.spacing[2] - 4) < 1e-4);
    QCOMPARE(info.sliceAxis, 2);
    QCOMPARE(info.orientation, QString("oblique"));
    QVERIFY(info.range[1] > 80 && info.range[0] >= 0);
    const auto item = host_->document().volume(id);
    // The image shares the voxels, and its matrix is RAS: x and y of LPS turned.
    QVERIFY(item->image->GetScalarPointer() == static_cast<const void*>(item->volume->voxels.data()));
    const Vec3 lps = item->volume->geometry.indexToWorld()({3, 4, 5});
    const double ijk[4] = {3, 4, 5, 1};
    double ras[4];
    item->ijkToRAS->MultiplyPoint(ijk, ras);
    QVERIFY(std::abs(ras[0] + lps[0]) < 1e-6 && std::abs(ras[1] + lps[1]) < 1e-6 &&
            std::abs(ras[2] - lps[2]) < 1e-6);
  }

  void imageOutlivesTheDocument() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii"));
    const vtkSmartPointer<vtkImageData> image = host_->document().volume(id)->image;
    const double before = image->GetScalarComponentAsDouble(12, 12, 5, 0);
    host_->document().remove(id);
    QCOMPARE(image->GetScalarComponentAsDouble(12, 12, 5, 0), before);
  }

  void saysWhatIsWrongWithAFile_data() {
    QTest::addColumn<QString>("kind");
    QTest::addColumn<QString>("words");
    QTest::newRow("missing") << "missing"
                             << "does not exist";
    QTest::newRow("not an image") << "text"
                                  << "not";
    QTest::newRow("colour") << "colour"
                            << "colour";
    QTest::newRow("one slice") << "slice"
                               << "single slice";
    QTest::newRow("folder without DICOM") << "folder"
                                          << "DICOM";
    QTest::newRow("broken model") << "model"
                                  << "model";
  }
  void saysWhatIsWrongWithAFile() {
    QFETCH(QString, kind);
    QFETCH(QString, words);
    QString path = sandbox_->path(kind == "model" ? "broken.innergs" : "file.nii");
    if (kind == "text" || kind == "model") {
      QFile file(path);
      QVERIFY(file.open(QIODevice::WriteOnly));
      file.write("Dear reader, this is a letter.\n");
    }
    if (kind == "colour") path = writeRgb(*sandbox_, "rgb.nii");
    if (kind == "slice") path = writeBall(*sandbox_, "slice.nii", {24, 24, 1});
    if (kind == "folder") {
      path = sandbox_->path("empty");
      QVERIFY(QDir().mkpath(path));
    }
    QString error;
    QVERIFY(openAndWait(*host_, path, &error).isEmpty());
    qInfo("%s", qPrintable(error));
    QVERIFY2(error.contains(words, Qt::CaseInsensitive), qPrintable(error));
    QVERIFY(error.endsWith('.'));
    QVERIFY(!error.contains("itk", Qt::CaseInsensitive) && !error.contains("exception", Qt::CaseInsensitive));
    QVERIFY(host_->document().volumes().empty());
  }

  void estimatesQuickly() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {128, 128, 40}));
    ui::Request request = apptest::request(id);
    request.evaluateQuality = true;
    QElapsedTimer timer;
    timer.start();
    ui::Estimate estimate = host_->estimate(request);
    QVERIFY2(timer.elapsed() <= 50, qPrintable(QString::number(timer.elapsed())));
    QVERIFY(estimate.refusal.isEmpty());
    QVERIFY(estimate.memory > 1 << 20);
    // Device and time come a moment later.
    QTRY_VERIFY_WITH_TIMEOUT(host_->estimate(request).seconds > 0, 30000);
    estimate = host_->estimate(request);
    QVERIFY(estimate.reason.contains("CPU"));
    request.inputs.clear();
    QVERIFY(!host_->estimate(request).refusal.isEmpty());
    request = apptest::request(id);
    request.settings.gaussians = -5;
    QVERIFY(!host_->estimate(request).refusal.isEmpty());
  }

  void reconstructsTwiceIntoNewItems() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    const auto input = host_->document().volume(id)->volume;
    QSignalSpy progress(host_.get(), &AppHost::progressed);
    const ui::Report first = reconstruct(apptest::request(id));
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
    // Window and level stay: result and input share one.
    QVERIFY(host_->document().volume(first.volumeId)->window == host_->document().volume(id)->window);
    const ui::Report second = reconstruct(apptest::request(id));
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
    const ui::Report third = reconstruct(over);
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
    const ui::Report report = reconstruct(request);
    QVERIFY(report.quality.size() >= 4);
    QVERIFY(!report.qualitySamples.isEmpty());
    QVERIFY(std::isfinite(report.heldOutPsnr));
    for (const ui::QualityRow& row : report.quality)
      QVERIFY(row.psnr > 10 && row.ssim <= 1);
  }

  void cancelsWithin200ms() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {48, 48, 16}));
    QSignalSpy cancelled(host_.get(), &AppHost::cancelled), finished(host_.get(), &AppHost::finished),
        progress(host_.get(), &AppHost::progressed);
    for (const int after : {0, 50, 300}) {
      cancelled.clear();
      QVERIFY(host_->start(apptest::request(id, true)));
      QVERIFY(host_->isRunning());
      QTest::qWait(after);
      QElapsedTimer timer;
      timer.start();
      host_->cancel();
      QVERIFY(timer.elapsed() < 20);
      QVERIFY(cancelled.wait(5000));
      qInfo("cancelled() %lld ms after cancel(), %d ms into the fit", timer.elapsed(), after);
      QVERIFY(timer.elapsed() < 1000); // 200 ms on a machine that is not loaded
      QVERIFY(!host_->isRunning());
    }
    QVERIFY(finished.isEmpty());
    QCOMPARE(int(host_->document().volumes().size()), 1);
    QVERIFY(!reconstruct(apptest::request(id)).volumeId.isEmpty()); // and again
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
    QVERIFY(cancelled.wait(5000));
  }

  void failsOnTheThreadWithASentence() {
    // Every voxel is not a number: found out when the fit is prepared.
    Volume volume = ball({8, 8, 8}, {1, 1, 1});
    std::fill(volume.voxels.begin(), volume.voxels.end(), std::numeric_limits<float>::quiet_NaN());
    const QString id = host_->document().add(app::makeItem(std::move(volume), "nothing"));
    QSignalSpy failed(host_.get(), &AppHost::failed);
    QVERIFY(host_->start(apptest::request(id)));
    QVERIFY(failed.wait(10000));
    QVERIFY(failed.first().first().toString().contains("finite"));
    QVERIFY(!host_->isRunning());
  }

  void volumeClosedWhileItIsReconstructed() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    QSignalSpy finished(host_.get(), &AppHost::finished);
    ui::Request request = apptest::request(id);
    QVERIFY(host_->start(request));
    host_->document().remove(id);
    QVERIFY(finished.wait(60000));
    QCOMPARE(int(host_->document().volumes().size()), 1);
  }

  void deletedWhileRunning() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz", {48, 48, 16}));
    QVERIFY(host_->start(apptest::request(id, true)));
    QTest::qWait(100);
    QElapsedTimer timer;
    timer.start();
    host_.reset();
    QVERIFY(timer.elapsed() < 2000);
  }

  void savesAndReadsBack() {
    const QString id = openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz"));
    const ui::Report report = reconstruct(apptest::request(id));
    const QString volumeFile = sandbox_->path("result.nii.gz"), modelFile = sandbox_->path("result.innergs");
    QCOMPARE(host_->save(report.volumeId, volumeFile), QString());
    QCOMPARE(host_->saveModel(report.modelId, sandbox_->path("alone.ply")), QString());
    QVERIFY(!host_->modelInfo(report.modelId).saved); // Gaussians alone
    QCOMPARE(host_->modelInfo(report.modelId).file, QString());
    QCOMPARE(host_->saveModel(report.modelId, modelFile), QString());
    QVERIFY(!host_->document().hasUnsaved());
    QCOMPARE(host_->modelInfo(report.modelId).file, modelFile);
    const Volume back = readVolume(volumeFile.toStdString());
    QVERIFY(back.voxels == host_->document().volume(report.volumeId)->volume->voxels);
    QVERIFY(sameLattice(back.geometry, host_->document().volume(report.volumeId)->volume->geometry));
    QString error;
    const QString loaded = host_->loadModel(modelFile, &error);
    QCOMPARE(error, QString());
    QCOMPARE(host_->modelInfo(loaded).gaussians, host_->modelInfo(report.modelId).gaussians);
    QVERIFY(host_->model(loaded) && !host_->model(loaded)->IsEmpty());
    QCOMPARE(host_->saveModel(report.modelId, sandbox_->path("result.ply")), QString());
    QVERIFY(!host_->loadModel(sandbox_->path("result.ply"), &error).isEmpty());
    // What cannot be written says so, and the item stays unsaved or as it was.
    QVERIFY(host_->save(report.volumeId, sandbox_->path("no/such/folder/x.nii")).contains("folder"));
    QVERIFY(!host_->save(report.volumeId, sandbox_->path("x.jpeg")).isEmpty());
    QVERIFY(!host_->saveModel(report.modelId, sandbox_->path("x.txt")).isEmpty());
    QVERIFY(host_->loadModel(sandbox_->path("absent.innergs"), &error).isEmpty());
    QVERIFY(error.contains("does not exist"));
  }

  void replacedWhileItIsSaved() {
    app::VolumeItem item = app::makeItem(ball({64, 64, 64}, {1, 1, 1}), "result");
    item.saved = false;
    const auto first = item.volume;
    const QString id = host_->document().add(std::move(item));
    QTimer::singleShot(0, this, [&] { // while the thread writes
      app::VolumeItem other = app::makeItem(ball({8, 8, 8}, {1, 1, 1}), "other");
      other.saved = false;
      QVERIFY(host_->document().replace(id, std::move(other)));
    });
    const QString file = sandbox_->path("result.nii.gz");
    QCOMPARE(host_->save(id, file), QString());
    QCOMPARE(host_->volumeInfo(id).dimensions[0], 8);
    QVERIFY(!host_->document().volume(id)->saved); // the new one is in no file
    QVERIFY(readVolume(file.toStdString()).voxels == first->voxels);
  }

  void takesVolumesFromPanels() {
    vtkNew<vtkImageData> image;
    image->SetDimensions(5, 4, 3);
    image->AllocateScalars(VTK_FLOAT, 1);
    for (int n = 0; n < 60; ++n)
      static_cast<float*>(image->GetScalarPointer())[n] = float(n);
    vtkNew<vtkMatrix4x4> matrix;
    matrix->SetElement(0, 0, 2);
    matrix->SetElement(0, 3, 10);
    QString error;
    const QString id = host_->addVolume(image, matrix, "plane", &error);
    QCOMPARE(error, QString());
    QCOMPARE(host_->volumeInfo(id).spacing[0], 2.0);
    QCOMPARE(host_->document().volume(id)->ijkToRAS->GetElement(0, 3), 10.0);
    matrix->SetElement(1, 1, 0);
    QVERIFY(host_->addVolume(image, matrix, "flat", &error).isEmpty());
    QVERIFY(error.contains("inverted"));
  }

  void remembersFolderAndFiles() {
    host_->setFolder("/some/where");
    QCOMPARE(host_->folder(), QString("/some/where"));
    for (int n = 0; n < 14; ++n)
      app::addRecentFile(QString("/a/%1.nii").arg(n));
    app::addRecentFile("/a/8.nii");
    QCOMPARE(app::recentFiles().size(), 10);
    QCOMPARE(app::recentFiles().first(), QString("/a/8.nii"));
    QVERIFY(QFile::exists(sandbox_->path("settings.ini"))); // not among the user's
  }

  void opensTheSampleBrainOrSaysHowToGetIt() {
    QSignalSpy opened(host_.get(), &AppHost::opened), failed(host_.get(), &AppHost::openFailed);
    host_->openSample();
    QTRY_VERIFY_WITH_TIMEOUT(opened.size() + failed.size() == 1, 60000);
    if (app::sampleBrain().isEmpty()) {
      QVERIFY(failed.first().at(1).toString().contains("mricron-data"));
      return;
    }
    const auto& volumes = host_->document().volumes();
    QCOMPARE(int(volumes.size()), 2);
    QCOMPARE(opened.first().first().toString(), volumes[0]->id);
    QVERIFY(std::abs(volumes[0]->volume->geometry.spacing[2] - 5 * volumes[1]->volume->geometry.spacing[2]) <
            1e-6);
    QVERIFY(!host_->document().hasUnsaved());
  }

  void opensRealFiles() {
    const QString dicom = testData("G_dicom_mr_T1_oblique"), minc = testData("G_minc2_4d.mnc");
    if (dicom.isEmpty() || minc.isEmpty()) QSKIP("no test data: INNERGS_TEST_DATA is not set or incomplete");
    const QString id = openAndWait(*host_, dicom);
    QVERIFY(!id.isEmpty());
    QVERIFY(host_->volumeInfo(id).sliceThickness > 0);
    QSignalSpy logged(host_.get(), &AppHost::logged);
    QVERIFY(!openAndWait(*host_, minc).isEmpty());
    QVERIFY(logged.last().first().toString().contains("frames"));
    QCOMPARE(host_->document().volumes().back()->name, QString("G_minc2_4d frame 1"));
    QString error;
    QVERIFY(openAndWait(*host_, testData("G_rgb24_ct_perfusion.nii.gz"), &error).isEmpty());
    QVERIFY2(error.contains("colour") || error.contains("RGB"), qPrintable(error));
    QVERIFY(openAndWait(*host_, testData("G_single_slice.nii.gz"), &error).isEmpty());
    QVERIFY2(error.contains("slice"), qPrintable(error));
  }
};

QTEST_GUILESS_MAIN(AppHostTest)
#include "AppHostTest.moc"
