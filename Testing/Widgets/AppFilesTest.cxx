// Opening and saving in the desktop app: every kind of file, problems with files, where results go.
#include "AppWindowTest.h"

#include "IO/VolumeIO.h"
#include "Widgets/App/SampleBrain.h"

#include <QDir>
#include <QDropEvent>
#include <QLabel>
#include <QMimeData>
#include <QScopeGuard>
#include <QSpinBox>
#include <QUrl>

#include <limits>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;
using innergs::app::MainWindow;
using innergs::app::SliceView;

class AppFilesTest : public AppWindowTest {
  Q_OBJECT
private Q_SLOTS:
  void saysWhatIsWrong() {
    window_->host()->open({sandbox_->path("absent.nii")});
    QVERIFY(errorText().contains("does not exist; check the path."));
    window_->host()->open({writeRgb(*sandbox_, "rgb.nii")});
    QVERIFY(errorText().contains("colour (RGB) pixels; convert it to grey values first."));
    // Several at once in one box.
    window_->host()->open({writeBall(*sandbox_, "slice.nii", {16, 16, 1}), sandbox_->path("absent.innergs"),
                           writeBall(*sandbox_, "fine.nii")});
    const QString text = errorText();
    QVERIFY(text.contains("single slice") && text.contains("absent.innergs"));
    QCOMPARE(lines(), QStringList{"fine"});
  }

  void opensByDragAndDrop() {
    QMimeData data;
    data.setUrls({QUrl::fromLocalFile(writeBall(*sandbox_, "one.nii")),
                  QUrl::fromLocalFile(writeBall(*sandbox_, "two words ü.nii.gz"))});
    QDragEnterEvent enter({50, 50}, Qt::CopyAction, &data, Qt::LeftButton, {});
    QCoreApplication::sendEvent(window_.get(), &enter);
    QVERIFY(enter.isAccepted());
    QDropEvent drop({50, 50}, Qt::CopyAction, &data, Qt::LeftButton, {});
    QCoreApplication::sendEvent(window_.get(), &drop);
    TRY_COMPARE(lines(), (QStringList{"one", "two words ü"}));
    QMimeData text;
    text.setText("hello");
    QDragEnterEvent other({50, 50}, Qt::CopyAction, &text, Qt::LeftButton, {});
    other.setAccepted(false);
    QCoreApplication::sendEvent(window_.get(), &other);
    QVERIFY(!other.isAccepted());
  }

  void savesAsChosenAndReplacesNothingUnasked() {
    QVERIFY(QDir().mkpath(sandbox_->path("scans")));
    open({writeBall(*sandbox_, "scans/ball.nii.gz")});
    answerFileDialog(sandbox_->path("t1 1.5mm"));
    trigger("saveVolume");
    const QString whole = sandbox_->path("t1 1.5mm.nii.gz");
    QVERIFY(QFile::exists(whole));
    QFile kept(whole);
    QVERIFY(kept.open(QIODevice::WriteOnly));
    kept.write("precious");
    kept.close();
    QString text;
    answerBox("replaceBox", "No", &text);
    answerFileDialog(sandbox_->path("t1 1.5mm"));
    trigger("saveVolume");
    QVERIFY(text.contains("t1 1.5mm.nii.gz"));
    QCOMPARE(QFileInfo(whole).size(), qint64(8));
    answerFileDialog(sandbox_->path("plain"), "NRRD");
    trigger("saveVolume");
    QVERIFY(QFile::exists(sandbox_->path("plain.nrrd")) && !QFile::exists(sandbox_->path("plain.nii.gz")));
    answerFileDialog(sandbox_->path("v2.5"), "NRRD");
    trigger("saveVolume");
    QVERIFY(QFile::exists(sandbox_->path("v2.5.nrrd")));
  }

  void opensLargeFilesWithoutHoldingTheWindow() {
    const QString file = writeBall(*sandbox_, "large.nii.gz", {160, 160, 120}, {1, 1, 1});
    window_->host()->open({file});
    QVERIFY(host().background().isBusy()); // on its thread
    TRY_VERIFY(!host().background().isBusy());
    QCOMPARE(lines(), QStringList{"large"});
  }

  void oneFrameOfAFourDimensionalFile() {
    const QString file = writeFrames(*sandbox_, "series.nii", 5, 2.5f);
    open({writeBall(*sandbox_, "ball.nii"), file});
    auto* frame = window_->findChild<QSpinBox*>("frame");
    auto* time = window_->findChild<QLabel*>("frameTime");
    QCOMPARE(lines(), (QStringList{"ball", "series frame 1"}));
    const QString id = host().document().volumes()[1]->id;
    QVERIFY(frame->isVisible());
    QCOMPARE(frame->text(), QString("1 of 5"));
    QCOMPARE(time->text(), QString("at 0 s"));
    QVERIFY(tree()->topLevelItem(1)->toolTip(0).contains("holds 5 frames"));
    const auto first = host().document().volume(id)->volume;
    const auto window = host().document().volume(id)->window;
    // By keyboard, faster than it can be read.
    window_->activateWindow();
    frame->setFocus();
    QTest::keyClick(frame, Qt::Key_Up);
    QTest::keyClick(frame, Qt::Key_Up);
    TRY_COMPARE(lines()[1], QString("series frame 3"));
    TRY_VERIFY(!host().background().isBusy());
    QCOMPARE(frame->value(), 3);
    QCOMPARE(time->text(), QString("at 5 s"));
    const auto third = host().document().volume(id);
    QCOMPARE(third->volume->voxels[1000], 3 * first->voxels[1000]);
    QVERIFY(third->window == window && window_->state()->volume() == third);
    QVERIFY(!host().document().hasUnsaved());
    // Volumes made from it say so too, and a user's own name is kept.
    setQuick();
    reconstruct();
    QCOMPARE(lines()[2], QString("series frame 3 reconstructed"));
    QVERIFY(!frame->isVisible());
    host().document().rename(id, "Rest");
    chooseLine(1);
    QVERIFY(frame->isVisible());
    frame->setValue(5);
    TRY_COMPARE(lines()[1], QString("Rest frame 5"));
    // A single image offers no choice, and a missing file is reported.
    chooseLine(0);
    QVERIFY(!frame->isVisible());
    chooseLine(1);
    QVERIFY(QFile::remove(file));
    frame->setValue(2);
    QVERIFY(errorText().contains("does not exist"));
    QCOMPARE(frame->value(), 5);
    QCOMPARE(lines()[1], QString("Rest frame 5"));
  }

  void saysWhatWasDoneToOpenIt() {
    Volume volume = ball({8, 8, 8}, {1, 1, 1});
    volume.voxels[3] = std::numeric_limits<float>::quiet_NaN();
    volume.voxels[77] = std::numeric_limits<float>::infinity();
    const QString holes = sandbox_->path("holes.nii"), iteration = sandbox_->path("iteration.mha");
    writeVolume(volume, holes.toStdString());
    volume.voxels.assign(512, std::numeric_limits<float>::quiet_NaN());
    const QString nothing = sandbox_->path("nothing.nii");
    writeVolume(volume, nothing.toStdString());
    writeVolume(ball({8, 8, 8}, {1, 1, 1}), iteration.toStdString());
    QFile file(iteration);
    QVERIFY(file.open(QIODevice::ReadWrite));
    QByteArray bytes = file.readAll();
    bytes.replace("ElementType",
                  "Seq_Frame0000_ProbeToTrackerTransform = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\nElementType");
    file.seek(0);
    file.write(bytes);
    file.close();
    QSignalSpy logged(&host(), &AppHost::logged);
    answerBox("calibrationBox", "Cancel");
    open({holes, iteration});
    QCOMPARE(lines(), (QStringList{"holes", "iteration"}));
    QVERIFY(tree()->topLevelItem(0)->toolTip(0).contains("2 of 512 voxels"));
    QVERIFY(tree()->topLevelItem(1)->toolTip(0).contains("tracked sweep"));
    QVERIFY(logged.last().first().toString().contains("tracked sweep"));
    window_->host()->open({nothing});
    QVERIFY(errorText().contains("no voxel with a finite value"));
  }

  void asksForTheCalibrationOfATrackedSweep() {
    const QString sweep = writeSweep(*sandbox_, "sweep.igs.mha", false);
    QString text;
    answerBox("calibrationBox", "Choose File…", &text);
    answerFileDialog(sweepCalibration(*sandbox_));
    open({sweep});
    TRY_VERIFY(host().document().volumes().front()->poses.size() == 33);
    QVERIFY(text.contains("ImageToProbe"));
    QVERIFY(tree()->topLevelItem(0)->toolTip(0).contains("puts each where it lies"));
    QVERIFY(window_->findChild<QLabel*>("inputDescription")->text().contains("a place of its own"));
  }

  void asksForTheSampleBrainWhereThereIsNone() {
    // Qt's data folders can be redirected only on Linux.
    const QByteArray system = qgetenv("XDG_DATA_DIRS"), user = qgetenv("XDG_DATA_HOME");
    qputenv("XDG_DATA_DIRS", sandbox_->path("share").toUtf8());
    qputenv("XDG_DATA_HOME", sandbox_->path("home").toUtf8());
    const auto back = qScopeGuard([&] {
      system.isNull() ? qunsetenv("XDG_DATA_DIRS") : qputenv("XDG_DATA_DIRS", system);
      user.isNull() ? qunsetenv("XDG_DATA_HOME") : qputenv("XDG_DATA_HOME", user);
    });
    if (!app::sampleBrain().isEmpty()) QSKIP("the sample brain is found beside the program");
    const QString coarse = writeBall(*sandbox_, "coarse.nii"),
                  head = writeBall(*sandbox_, "head.nii.gz", {40, 40, 43}, {1, 1, 1});
    QString text;
    answerBox("sampleBox", "Cancel", &text);
    trigger("openSample");
    TRY_VERIFY(text.contains("choose the file ch2.nii.gz"));
    QVERIFY(!window_->findChild<QFileDialog*>());
    const auto choose = [&](const QString& file) {
      TRY_VERIFY(!window_->findChild<QMessageBox*>("sampleBox"));
      answerBox("sampleBox", "Choose File…");
      answerFileDialog(file);
      trigger("openSample");
    };
    choose(coarse);
    QVERIFY(errorText().contains("too coarse"));
    QVERIFY(lines().isEmpty());
    choose(head);
    TRY_COMPARE(lines(), (QStringList{"head, 5 mm slices", "head, 1 mm"}));
    QCOMPARE(host().document().volumes()[0]->volume->geometry.size[2], std::int64_t(8));
    QVERIFY(!host().document().hasUnsaved());
    // The head is for comparison and is never reconstructed.
    const auto input = [&] { return window_->reconstruction()->request().inputs.value(0).id; };
    const QString scan = host().document().volumes()[0]->id;
    QCOMPARE(input(), scan);
    trigger("nextVolume");
    QCOMPARE(window_->state()->volume()->name, QString("head, 1 mm"));
    QCOMPARE(input(), scan);
    trigger("nextVolume");
    QCOMPARE(window_->state()->volumeId(), scan);
    QCOMPARE(input(), scan);
    // Remembered; and one in the system's folders needs no choice.
    QCOMPARE(app::sampleBrain(), head);
    QVERIFY(QFile::remove(head));
    QVERIFY(app::sampleBrain().isEmpty());
    QVERIFY(QDir().mkpath(sandbox_->path("share/mricron/templates")));
    const QString found = writeBall(*sandbox_, "share/mricron/templates/ch2.nii.gz", {40, 40, 43}, {1, 1, 1});
    QCOMPARE(app::sampleBrain(), QFileInfo(found).canonicalFilePath());
    trigger("openSample");
    TRY_COMPARE(lines().size(), 4);
    QCOMPARE(lines()[2], QString("Brain, 5 mm slices"));
    QVERIFY(host().document().volumes()[0]->caveat.isEmpty());
    QVERIFY(host().document().volumes()[2]->caveat.contains("not held out"));
  }

  void opensRealVolumes() {
    const QString dicom = testData("G_dicom_mr_T1_oblique"),
                  thick = testData("F_icbm152_thick5mm_cor.nii.gz");
    if (dicom.isEmpty() || thick.isEmpty()) QSKIP("no test data: INNERGS_TEST_DATA is not set or incomplete");
    open({dicom, thick});
    QCOMPARE(lines().size(), 2);
    QCOMPARE(host().volumeInfo(host().document().volumes()[1]->id).orientation, QString("coronal"));
    QCOMPARE(lines().front(), QString("G_dicom_mr_T1_oblique"));
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppFilesTest>(argc, argv);
}
#include "AppFilesTest.moc"
