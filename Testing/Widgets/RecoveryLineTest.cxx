// What the panel offers when a fit was stopped from outside.
#include "ReconstructionPanelFixture.h"

#include <QDir>
#include <QFile>
#include <QSignalSpy>
#include <QSpinBox>
#include <QTemporaryDir>

#include "IO/RecoveredFit.h"
#include "Widgets/RecoveryLine.h"

using namespace innergs::ui;

class RecoveryLineTest : public ReconstructionPanelFixture {
  Q_OBJECT

private Q_SLOTS:
  void init() {
    make({});
    host_->recovery = folder_.filePath("recovery");
  }
  void cleanup() {
    area_.reset();
    host_.reset();
    QDir(folder_.filePath("recovery")).removeRecursively();
  }

  void offersWhatTheSceneTookAway() {
    QVERIFY(!isShown("recoveryLine"));
    start();
    const QString file = keep("T2", 37, 480);
    host_->sendEnded("Closing the scene ended the reconstruction.");
    QVERIFY(isShown("recoveryLine"));
    QVERIFY(line("recovery").contains("T2") && line("recovery").contains("37 of 480"));
    QVERIFY(line("recovery").contains(QDir::toNativeSeparators(file)));
    QCOMPARE(line("message"), QString("Closing the scene ended the reconstruction."));
    QCOMPARE(child<MessageLine>("message")->kind(), MessageLine::Kind::Information);
    // Another failure is only that.
    clickWhenEnabled();
    host_->sendFailed("Out of memory.");
    QVERIFY(line("message").contains("Change something"));
  }

  void goesOnWithItsSettings() {
    const QString file = keep("T2", 37, 480);
    area_->hide();
    QVERIFY(showActive(*area_)); // it looks again
    QSignalSpy changed(panel_, &ReconstructionPanel::requestChanged);
    QTest::mouseClick(child<QPushButton>("goOn"), Qt::LeftButton);
    QVERIFY(changed.count() > 0);
    QCOMPARE(panel_->request().resumeFile, file);
    QCOMPARE(panel_->request().settings.iterations, std::optional<int>(480));
    QCOMPARE(panel_->request().settings.preset, innergs::Preset::Best);
    QVERIFY(!isShown("goOn"));
    QVERIFY(line("recovery").contains("continues that of 'T2'"));
    start();
    QCOMPARE(host_->requests.last().resumeFile, file);
    QVERIFY(!isShown("recoveryLine"));
    QFile::remove(file); // as the hosts do
    host_->sendFinished(FakeHost::exampleReport());
    QCOMPARE(panel_->request().resumeFile, QString());
    QVERIFY(!isShown("recoveryLine"));
  }

  void startsAnewOrForgets() {
    const QString file = keep("T2", 480, 480);
    panel_->setRequest(panel_->request());
    area_->hide();
    QVERIFY(showActive(*area_));
    QVERIFY(line("recovery").contains("when its fit was complete"));
    QTest::mouseClick(child<QPushButton>("goOn"), Qt::LeftButton);
    QTest::mouseClick(child<QPushButton>("dropRecovered"), Qt::LeftButton);
    QCOMPARE(panel_->request().resumeFile, QString());
    QVERIFY(QFile::exists(file) && isShown("goOn"));
    QTest::mouseClick(child<QPushButton>("dropRecovered"), Qt::LeftButton);
    QVERIFY(!QFile::exists(file));
    QVERIFY(!isShown("recoveryLine"));
  }

  void everyWordIsSeen() {
    keep("A scan with a rather long name; another scan with a name as long", 37, 480);
    area_->hide();
    QVERIFY(showActive(*area_));
    layOut();
    auto* shown = child<QWidget>("recoveryLine");
    QVERIFY(shown->width() <= area_->viewport()->width());
    QVERIFY(shown->height() >= shown->heightForWidth(shown->width()) || !shown->hasHeightForWidth());
  }

private:
  QString keep(const std::string& inputs, int iteration, int iterations) {
    innergs::Model model;
    model.field.gaussians.resize(1);
    model.iteration = iteration;
    innergs::RecoveredFit fit;
    fit.inputs = inputs;
    fit.settings.preset = innergs::Preset::Best;
    fit.settings.iterations = iterations;
    fit.iterations = iterations;
    const auto file = innergs::writeRecoveredFit(model, fit, host_->recovery.toStdU16String());
    return QString::fromStdU16String(file.u16string());
  }

  QTemporaryDir folder_;
};

QTEST_MAIN(RecoveryLineTest)
#include "RecoveryLineTest.moc"
