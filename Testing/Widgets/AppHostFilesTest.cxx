// The desktop app's host: files, volumes and models in and out; without a window.
#include "AppFixture.h"
#include "SyntheticDicom.h"

#include "Core/Features/FeatureTraining.h"
#include "IO/ModelFile.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/SampleBrain.h"
#include "Widgets/App/SegmentItems.h"

#include <QDir>
#include <QFile>
#include <QScopeGuard>
#include <QSignalSpy>
#include <QTest>
#include <QTimer>

#include <vtkImageData.h>
#include <vtkNew.h>

#include <cmath>
#include <memory>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;

class AppHostFilesTest : public HostTest {
  Q_OBJECT
private Q_SLOTS:
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
    const auto item = host_->document().volume(id);
    QVERIFY(item->range[1] > 80 && item->range[0] >= 0);
    // The image shares the voxels, and its matrix is RAS: x and y of LPS turned.
    QVERIFY(item->image->GetScalarPointer() == static_cast<const void*>(item->volume->voxels.data()));
    const Vec3 lps = item->volume->geometry.indexToWorld()({3, 4, 5});
    const double ijk[4] = {3, 4, 5, 1};
    double ras[4];
    item->ijkToRAS->MultiplyPoint(ijk, ras);
    QVERIFY(std::abs(ras[0] + lps[0]) < 1e-6 && std::abs(ras[1] + lps[1]) < 1e-6 &&
            std::abs(ras[2] - lps[2]) < 1e-6);
  }

  void keepsWhatAModelLearnedAboutSegments() {
    const ui::Report made =
        reconstructAndWait(*host_, request(openAndWait(*host_, writeBall(*sandbox_, "b.nii"))));
    const auto core = host_->document().model(made.modelId)->model->GetCoreModel();
    Labelmap labels{core->field.region(), {}, {}};
    for (std::int64_t n = 0; n < labels.geometry.voxelCount(); ++n)
      labels.voxels.push_back(n % labels.geometry.size[0] < labels.geometry.size[0] / 2 ? 1 : 2);
    FeatureTraining quick;
    quick.iterations = 2;
    const FeatureModel features = trainFeatures(core->field, labels, {{1, "liver"}, {2, "spleen"}}, quick);
    writeModel(*core, app::pathOf(sandbox_->path("named.innergs")), {}, &features);

    const QString id = openAndWait(*host_, sandbox_->path("named.innergs"));
    QCOMPARE(host_->model(id)->GetNumberOfSegments(), 2);
    QVERIFY(host_->modelInfo(id).description.contains("2 named segments"));
    QCOMPARE(host_->saveModel(id, sandbox_->path("again.innergs")), QString());
    std::optional<FeatureModel> again;
    readModel(app::pathOf(sandbox_->path("again.innergs")), nullptr, &again);
    QVERIFY(again);
    QVERIFY(again->names == features.names);
    QVERIFY(again->latents == features.latents);
  }

  void learnsFromALabelmapFileAndKeepsSegmentsInOne() {
    const ui::Report made =
        reconstructAndWait(*host_, request(openAndWait(*host_, writeBall(*sandbox_, "b.nii"))));
    const auto item = host_->document().model(made.modelId);
    Volume labels{item->model->GetField()->region(), {}};
    for (std::int64_t n = 0; n < labels.geometry.voxelCount(); ++n)
      labels.voxels.push_back(n % labels.geometry.size[0] < labels.geometry.size[0] / 2 ? 1.f : 2.f);
    writeVolume(labels, app::pathOf(sandbox_->path("labels.nii")));
    const QString labelsId = openAndWait(*host_, sandbox_->path("labels.nii"));
    QString error;
    const auto unnamed = host_->labelsFor(made.modelId, labelsId, {}, &error);
    QVERIFY(unnamed);
    QVERIFY(app::sentenceOf([&] { unnamed({}); }).contains("have no names"));
    QVERIFY(!host_->labelsFor("nothing", labelsId, {}, &error));
    QVERIFY(error.contains("no longer open"));
    QFile names(sandbox_->path("names.json"));
    QVERIFY(names.open(QIODevice::WriteOnly));
    names.write(R"({"1": "liver", "2": "spleen"})");
    names.close();
    const NamedLabels given =
        host_->labelsFor(made.modelId, labelsId, sandbox_->path("names.json"), &error)({});
    QCOMPARE(given.names.size(), std::size_t(2));
    FeatureTraining quick;
    quick.iterations = 2;
    const auto field = item->model->GetField();
    const auto features =
        std::make_shared<const FeatureModel>(trainFeatures(*field, given.labels, given.names, quick));
    host_->document().setSaved(made.modelId, "m.innergs");
    QCOMPARE(host_->setFeatures(made.modelId, features), QString());
    QVERIFY(!host_->modelInfo(made.modelId).saved);
    QCOMPARE(host_->model(made.modelId)->GetNumberOfSegments(), 2);

    SegmentFinder finder({field, features, {}});
    finder.encode(field->region());
    const MadeSegments found = finder.make(finder.requested("liver", finder.find("liver")));
    std::shared_ptr<const app::SegmentOverlay> overlay;
    connect(host_.get(), &AppHost::segmentsPreviewed, this, [&](const auto& shown) { overlay = shown; });
    host_->previewSegments(made.modelId, found);
    QVERIFY(overlay);
    QCOMPARE(overlay->colors.size(), std::size_t(1));
    host_->previewSegments(made.modelId, {});
    QVERIFY(!overlay);
    QCOMPARE(host_->addSegments(made.modelId, found, &error), QString("liver"));
    const auto kept = host_->document().volumes().back();
    QVERIFY(!kept->saved);
    QCOMPARE(std::count(kept->volume->voxels.begin(), kept->volume->voxels.end(), 1.f),
             std::ptrdiff_t(found.segments[0].second.voxels));
    QCOMPARE(host_->save(kept->id, sandbox_->path("liver.seg.nrrd")), QString());
    const auto read = readSegmentNames(app::pathOf(sandbox_->path("liver.seg.nrrd")));
    QCOMPARE(read.size(), std::size_t(1));
    QCOMPARE(read[0].name, std::string("liver"));
    // And learned from again, with the names that the file has.
    const QString again = openAndWait(*host_, sandbox_->path("liver.seg.nrrd"));
    QCOMPARE(host_->labelsFor(made.modelId, again, {}, &error)({}).names.size(), std::size_t(1));
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
    QTest::newRow("half a file") << "half"
                                 << "truncated";
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
    if (kind == "half") {
      path = writeBall(*sandbox_, "half.nii.gz");
      QVERIFY(QFile::resize(path, QFileInfo(path).size() / 2));
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

  void savesAndReadsBack() {
    ui::Request request = apptest::request(openAndWait(*host_, writeBall(*sandbox_, "ball.nii.gz")));
    request.maskId = openAndWait(*host_, writeBall(*sandbox_, "mask.nii.gz"));
    const ui::Report report = reconstructAndWait(*host_, request);
    const QString volumeFile = sandbox_->path("result.nii.gz"), modelFile = sandbox_->path("result.innergs");
    QCOMPARE(host_->save(report.volumeId, volumeFile), QString());
    QCOMPARE(host_->saveModel(report.modelId, sandbox_->path("alone.ply")), QString());
    QVERIFY(!host_->modelInfo(report.modelId).saved); // Gaussians alone
    QCOMPARE(host_->modelInfo(report.modelId).file, QString());
    QCOMPARE(host_->saveModel(report.modelId, modelFile), QString());
    QVERIFY(!host_->document().hasUnsaved());
    QCOMPARE(host_->modelInfo(report.modelId).file, modelFile);
    ModelNotes notes;
    readModel(modelFile.toStdString(), &notes);
    QCOMPARE(notes["Inputs"], std::string("ball"));
    QCOMPARE(notes["Mask"], std::string("mask"));
    QCOMPARE(notes["Settings"], report.settings.toStdString());
    const Volume back = readVolume(volumeFile.toStdString());
    QVERIFY(back.voxels == host_->document().volume(report.volumeId)->volume->voxels);
    QVERIFY(sameGrid(back.geometry, host_->document().volume(report.volumeId)->volume->geometry));
    QString error;
    const QString loaded = host_->loadModel(modelFile, &error);
    QCOMPARE(error, QString());
    QCOMPARE(host_->modelInfo(loaded).gaussians, host_->modelInfo(report.modelId).gaussians);
    QVERIFY(host_->model(loaded) && !host_->model(loaded)->IsEmpty());
    QCOMPARE(host_->saveModel(report.modelId, sandbox_->path("result.ply")), QString());
    QVERIFY(!host_->loadModel(sandbox_->path("result.ply"), &error).isEmpty());
    // A failed write is reported, and the item stays unsaved or as it was.
    QVERIFY(host_->save(report.volumeId, sandbox_->path("no/such/folder/x.nii")).contains("folder"));
    QVERIFY(!host_->save(report.volumeId, sandbox_->path("x.jpeg")).isEmpty());
    QVERIFY(!host_->saveModel(report.modelId, sandbox_->path("x.txt")).isEmpty());
    QVERIFY(host_->loadModel(sandbox_->path("absent.innergs"), &error).isEmpty());
    QVERIFY(error.contains("does not exist"));
  }

  void saysThatAFolderCannotBeWritten() {
    const QString folder = sandbox_->path("closed");
    QVERIFY(QDir().mkpath(folder));
    QVERIFY(QFile::setPermissions(folder, QFile::ReadOwner | QFile::ExeOwner));
    const auto open = qScopeGuard(
        [&] { QFile::setPermissions(folder, QFile::ReadOwner | QFile::WriteOwner | QFile::ExeOwner); });
    if (QFile probe(folder + "/probe"); probe.open(QIODevice::WriteOnly))
      QSKIP("this user may write anywhere (root), or permissions are kept otherwise (Windows)");
    app::VolumeItem item = app::makeItem(ball({8, 8, 8}, {1, 1, 1}), "result");
    item.saved = false;
    const QString id = host_->document().add(std::move(item));
    const QString sentence = host_->save(id, folder + "/result.nii.gz");
    QVERIFY2(sentence.contains("choose another folder"), qPrintable(sentence));
    QVERIFY(host_->document().hasUnsaved());
    QVERIFY(QDir(folder).isEmpty());
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
    TRY_VERIFY(opened.size() + failed.size() == 1);
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

  void saysThatStartWeightsWereLearnedFromTheSample() {
    const QString head = writeBall(*sandbox_, "ch2.nii.gz", {40, 40, 43}, {1, 1, 1});
    QSignalSpy opened(host_.get(), &AppHost::opened);
    host_->openSample(head);
    TRY_COMPARE(opened.size(), 1);
    ui::Request request = apptest::request(opened.first().first().toString());
    for (const bool measured : {true, false}) {
      request.evaluateQuality = measured;
      const QString warnings = reconstructAndWait(*host_, request).warnings.join(' ');
      QVERIFY2(warnings.contains("not held out") == measured, qPrintable(warnings));
    }
  }

  void knowsInHowManyPassesSlicesWereAcquired() {
    const QString scan = writeBall(*sandbox_, "ball.nii.gz"); // of 10 slices
    QFile bids(sandbox_->path("ball.json"));
    QVERIFY(bids.open(QIODevice::WriteOnly));
    bids.write(R"({"SliceTiming": [0, 5, 1, 6, 2, 7, 3, 8, 4, 9]})");
    bids.close();
    const QString id = openAndWait(*host_, scan);
    QCOMPARE(host_->volumeInfo(id).passes, 2);
    app::ReconstructionTask task;
    task.inputs = {*host_->document().volume(id)};
    task.request.inputs << ui::InputChoice{};
    QCOMPARE(app::makeInput(task, false).stacks[0].times.size(), std::size_t(10));
    task.request.inputs[0].sliceAxis = 0;
    QVERIFY(app::makeInput(task, false).stacks[0].times.empty());
  }

  /// Where a gantry is tilted, each slice lies at a place of its own.
  void opensSlicesOffAGrid() {
    const QString folder = sandbox_->path("tilted");
    QVERIFY(QDir().mkdir(folder));
    for (int k = 0; k < 6; ++k)
      test::writeDicomSlice((folder + QString("/%1.dcm").arg(k)).toStdString(), {0, 2.0 * k, 5.0 * k}, {},
                            100 + k,
                            {{"0020|000d", "1.2.3"},
                             {"0020|000e", "1.2.3.4"},
                             {"0008|0018", "1.2.3.4." + std::to_string(k + 1)}});
    const auto item = host_->document().volume(openAndWait(*host_, folder));
    QVERIFY(item);
    QCOMPARE(item->poses.size(), std::size_t(6));
    QVERIFY(item->note.contains("displaced within their planes"));
    QVERIFY(item->note.contains("puts each where it lies"));
  }

  void opensEverySeriesOfADicomFolder() {
    const QString folder = sandbox_->path("dicom");
    const std::filesystem::path path(folder.toStdString());
    test::writeDicomStack(path, "T2 axial", 11, 4, 3.5, 100, {}, {{"0018|0050", "3"}});
    test::writeDicomStack(path, "Localiser", 12, 1, 1, 150);
    test::writeDicomStack(path, "PD T2", 13, 5, 2, 200, {}, {{"0018|0081", "12"}});
    test::writeDicomStack(path, "PD T2", 13, 5, 2, 300, {}, {{"0018|0081", "96"}});
    QSignalSpy logged(host_.get(), &AppHost::logged);
    const QString id = openAndWait(*host_, folder);
    const auto& volumes = host_->document().volumes();
    QCOMPARE(int(volumes.size()), 3);
    QCOMPARE(volumes[0]->id, id);
    QCOMPARE(volumes[0]->name, QString("T2 axial"));
    QCOMPARE(volumes[0]->thickness, 3.0);
    QCOMPARE(volumes[1]->name, QString("PD T2, echo time 12"));
    QCOMPARE(volumes[2]->name, QString("PD T2, echo time 96"));
    QCOMPARE(volumes[2]->range[0], 300.0);
    QString all;
    for (const auto& line : logged)
      all += line.first().toString();
    QVERIFY2(all.contains("'Localiser' was left out."), qPrintable(all));
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

QTEST_GUILESS_MAIN(AppHostFilesTest)
#include "AppHostFilesTest.moc"
