#include "Widgets/PlaneExport.h"
#include "FakeHost.h"
#include "Patience.h"

#include "Core/Job/ReconstructionJob.h"
#include "vtkInnerGSModel.h"

#include <vtkTransform.h>

#include <QApplication>
#include <QClipboard>
#include <QLocale>
#include <QSignalSpy>
#include <QtTest>

using namespace innergs;
using namespace innergs::ui;

class PlaneExportTest : public QObject {
  Q_OBJECT
  FakeHost host_;
  ModelPlane plane_;

private Q_SLOTS:
  void initTestCase() {
    plane_.modelId = host_.addBallModel("Ball");
    plane_.model = host_.modelInfo(plane_.modelId);
  }

  void init() {
    plane_.task = {};
    plane_.task.model = host_.model(plane_.modelId)->GetCoreModel();
    plane_.task.left = plane_.task.bottom = -8;
    plane_.task.columns = plane_.task.rows = 16;
    plane_.model.file.clear();
    plane_.model.saved = false;
    host_.addedVolumes.clear();
    host_.modelError.clear();
  }

  void eachVolumeGetsTheNameOfItsPlane() {
    PlaneWorker worker;
    PlaneExport planes(
        &host_, &worker, [this] { return plane_; }, nullptr);
    QSignalSpy said(&planes, &PlaneExport::said);
    plane_.task.pose.origin = {1, 2, 3};
    planes.addToVolumes();
    plane_.task.pose.orientation = PlaneOrientation::Coronal;
    planes.addToVolumes();
    plane_.task.pose.angles.inPlane = 45;
    planes.addToVolumes();
    TRY_COMPARE(said.size(), 3);
    QCOMPARE(host_.addedVolumes,
             (QStringList{"Ball axial 3.0 mm", "Ball coronal 2.0 mm", "Ball oblique 2.0 mm"}));
    for (const auto& signal : said)
      QCOMPARE(signal[1].toBool(), false);
  }

  void saysWhatFails() {
    PlaneWorker worker;
    PlaneExport planes(
        &host_, &worker, [this] { return plane_; }, nullptr);
    QSignalSpy said(&planes, &PlaneExport::said);
    host_.modelError = "The disk is full: free some space.";
    planes.addToVolumes();
    TRY_COMPARE(said.size(), 1);
    QCOMPARE(said[0][0].toString(), host_.modelError);
    QCOMPARE(said[0][1].toBool(), true);

    plane_.task.columns = plane_.task.rows = 10000;
    planes.addToVolumes();
    QCOMPARE(said.size(), 2); // at once
    QVERIFY(said[1][0].toString().endsWith("choose a larger pixel size."));
    QCOMPARE(said[1][1].toBool(), true);
  }

  void withoutAModelNothingHappens() {
    PlaneWorker worker;
    ModelPlane current;
    PlaneExport planes(
        &host_, &worker, [&current] { return current; }, nullptr);
    QSignalSpy said(&planes, &PlaneExport::said);
    planes.addToVolumes();
    planes.copyCommand();
    current = plane_;
    planes.addToVolumes(); // the worker keeps their order
    TRY_COMPARE(host_.addedVolumes.size(), 1);
    QCOMPARE(said.size(), 1);
  }

  void commandNamesTheModelsFile() {
    PlaneWorker worker;
    PlaneExport planes(
        &host_, &worker, [this] { return plane_; }, nullptr);
    QSignalSpy said(&planes, &PlaneExport::said);
    const auto command = [&] {
      planes.copyCommand();
      return QGuiApplication::clipboard()->text();
    };
    QVERIFY(command().startsWith("innergs slice \"Ball.innergs\" --ras "));
    QVERIFY(said[0][0].toString().contains("save the model"));
    plane_.model.file = "scans/head.innergs";
    plane_.model.saved = true;
    const QString saved = command();
    QVERIFY2(saved.contains("head.innergs\" --ras "), qPrintable(saved));
    QVERIFY(saved.endsWith(" --center 0.500000,-0.500000,0.000000 --size 16,16 --spacing 1 -o plane.nii.gz"));

    plane_.task.toModel = vtkSmartPointer<vtkTransform>::New();
    plane_.model.file = "other.innergs";
    QCOMPARE(command(), saved);
    QVERIFY(said[2][0].toString().contains("harden the transform"));
    QCOMPARE(said[2][1].toBool(), true);
  }
};

int main(int argc, char** argv) {
  QLocale::setDefault(QLocale::c());
  QApplication app(argc, argv);
  PlaneExportTest test;
  return QTest::qExec(&test, argc, argv);
}
#include "PlaneExportTest.moc"
