#include "Widgets/LogPanel.h"

#include "FakeHost.h"
#include "TestTools.h"

#include <QClipboard>
#include <QGuiApplication>
#include <QPushButton>

using namespace innergs::ui;
using innergs::Phase;

class LogPanelTest : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void theLogIsCopied() {
    FakeHost host;
    LogPanel log(&host);
    QVERIFY(showActive(log));
    Q_EMIT host.logged("Opened head.nii.gz");
    host.start({});
    host.sendProgress(Phase::Fitting, 0.5, 1, 0.1, 20, 3, "On the CPU, as asked.");
    host.sendFinished(FakeHost::exampleReport());
    for (const char* part : {"Opened head.nii.gz", "Reconstruction started.", "On the CPU, as asked.",
                             "Done in 1 min 23 s: 74,088 Gaussians.", "Warning: The slices are thicker",
                             "38.25 dB on the fitted samples, not held out.", "InnerGS: 31.62 dB",
                             "Linear interpolation: 30.11 dB", "Settings: preset=balanced"})
      QVERIFY2(log.text().contains(part), part);
    QTest::mouseClick(log.findChild<QPushButton*>("copyLog"), Qt::LeftButton);
    QCOMPARE(QGuiApplication::clipboard()->text(), log.text() + '\n');
    host.start({});
    host.sendFailed("It broke: do this.");
    QVERIFY(log.text().contains("Error: It broke: do this."));
    snapshot(log, "log");
  }
};

QTEST_MAIN(LogPanelTest)
#include "LogPanelTest.moc"
