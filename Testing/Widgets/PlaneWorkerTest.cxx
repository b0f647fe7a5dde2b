#include "Widgets/PlaneWorker.h"
#include "FittedModel.h"
#include "Patience.h"
#include "ThreadShortage.h"

#include "Core/Job/ReconstructionJob.h"

#include <vtkImageData.h>

#include <QCoreApplication>
#include <QThread>
#include <QtTest>

using namespace innergs;
using namespace innergs::ui;

class PlaneWorkerTest : public QObject {
  Q_OBJECT
  FakeHost host_;
  std::shared_ptr<const Model> model_;

  PlaneTask task(double position, int side = 64) {
    PlaneTask task;
    task.model = model_;
    task.pose.origin[2] = position;
    task.left = task.bottom = -0.5 * side;
    task.columns = task.rows = side;
    return task;
  }

private Q_SLOTS:
  void initTestCase() { model_ = host_.model(host_.addBallModel())->GetCoreModel(); }

  void theLatestIsShownAndOthersSkipped() {
    PlaneWorker worker;
    QVector<PlaneImage> seen;
    connect(&worker, &PlaneWorker::shown, this, [&](const PlaneImage& image) {
      QCOMPARE(QThread::currentThread(), qApp->thread());
      seen.append(image);
    });
    for (int i = 0; i < 300; ++i)
      worker.show(task(0.1 * i, 256), i % 3 == 0);
    TRY_VERIFY(!seen.isEmpty() && seen.last().task.pose.origin[2] == 0.1 * 299);
    QVERIFY2(seen.size() < 100, qPrintable(QString::number(seen.size())));
    for (const PlaneImage& image : seen) {
      QVERIFY(image.image);
      QCOMPARE(image.image->GetNumberOfPoints(), vtkIdType{256 * 256});
    }
  }

  void tellsWhenNoThreadCanBeStarted() {
    if (!innergs::test::ThreadShortage::known()) QSKIP("This system's threads cannot be refused here.");
    PlaneWorker worker;
    QVector<PlaneImage> seen;
    connect(&worker, &PlaneWorker::shown, this, [&](const PlaneImage& image) { seen.append(image); });
    {
      const innergs::test::ThreadShortage shortage(0);
      worker.show(task(0));
    }
    TRY_COMPARE(seen.size(), 1);
    QVERIFY2(seen[0].error.starts_with("The system could not start another thread: "), seen[0].error.c_str());
    worker.show(task(0));
    TRY_COMPARE(seen.size(), 2);
    QVERIFY(seen[1].image);
  }

  void whatIsToKeepIsAllDone() {
    PlaneWorker worker;
    QVector<double> exported;
    connect(&worker, &PlaneWorker::exported, this, [&](const PlaneImage& image) {
      QVERIFY(image.image);
      exported.append(image.task.pose.origin[2]);
    });
    for (int i = 0; i < 5; ++i) {
      worker.exportPlane(task(i));
      worker.show(task(10 * i, 512), true);
      worker.probe(task(i));
    }
    worker.clear();
    TRY_COMPARE(exported.size(), 5);
    QCOMPARE(exported, (QVector<double>{0, 1, 2, 3, 4}));
  }

  void aKeptImageIsNotOverwritten() {
    PlaneWorker worker;
    QVector<PlaneImage> exported;
    connect(&worker, &PlaneWorker::exported, this, [&](const PlaneImage& image) { exported.append(image); });
    worker.exportPlane(task(0));
    worker.exportPlane(task(39));
    TRY_COMPARE(exported.size(), 2);
    QVERIFY(exported[0].image->GetScalarComponentAsDouble(32, 32, 0, 0) >
            5 + exported[1].image->GetScalarComponentAsDouble(32, 32, 0, 0));
  }

  void errorsAreSentences() {
    PlaneWorker worker;
    QVector<PlaneImage> seen;
    connect(&worker, &PlaneWorker::shown, this, [&](const PlaneImage& image) { seen.append(image); });
    PlaneTask bad = task(0);
    bad.pixelSize = -1;
    worker.show(bad);
    TRY_COMPARE(seen.size(), 1);
    QVERIFY(!seen[0].image);
    QVERIFY2(seen[0].error.find("spacing must be finite and above zero") != std::string::npos,
             seen[0].error.c_str());
    worker.show(task(0)); // it continues
    TRY_COMPARE(seen.size(), 2);
    QVERIFY(seen[1].image && seen[1].error.empty());
    bad = task(0);
    bad.model = std::make_shared<Model>();
    worker.show(bad);
    TRY_COMPARE(seen.size(), 3);
    QVERIFY2(seen[2].error.ends_with("."), seen[2].error.c_str());
  }

  void endsWithWorkInHand() {
    int done = 0;
    for (int i = 0; i < 20; ++i) {
      PlaneWorker worker;
      connect(&worker, &PlaneWorker::shown, this, [&] { ++done; });
      connect(&worker, &PlaneWorker::exported, this, [&] { ++done; });
      worker.show(task(0, 2000));
      worker.exportPlane(task(0, 2000));
    }
    QCoreApplication::processEvents();
    QCOMPARE(done, 0); // there is no receiver
  }
};

QTEST_GUILESS_MAIN(PlaneWorkerTest)
#include "PlaneWorkerTest.moc"
