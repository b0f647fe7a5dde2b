#include "ReconstructionPanelFixture.h"
#include "Widgets/QualityVerdict.h"

using namespace innergs::ui;

/// What the panel says of a result's quality.
class QualityCardTest : public ReconstructionPanelFixture {
  Q_OBJECT

private Q_SLOTS:
  void everyFigureSaysItsSamples() {
    finish(FakeHost::exampleReport());
    QCOMPARE(label("resultSummary"),
             QString("Done in 1 min 23 s. 74,088 Gaussians. On the CPU. The CUDA backend is not installed."));
    QCOMPARE(label("qualityVerdict"),
             QString("On held-out slices, InnerGS is better than the others: 1.5 dB more PSNR than "
                     "linear interpolation, 0.021 more SSIM than linear interpolation."));
    QVERIFY(label("qualitySamples").startsWith("Scored on held-out slices. Every 4th slice"));
    QCOMPARE(label("quality-1-0"), QString("InnerGS"));
    QCOMPARE(label("quality-1-1"), QString("31.62"));
    QCOMPARE(label("quality-2-0"), QString("Linear interpolation"));
    QCOMPARE(label("heldOutQuality"),
             QString("31.50 dB PSNR on 12 held-out slices, from a second fit that did not see them."));
    QVERIFY(label("trainingQuality").startsWith("38.25 dB PSNR on the fitted samples, not held out"));
    QVERIFY(line("resultWarnings").contains("thickness was set to 4 mm."));
    scrollDown();
    snapshot(*area_, "panel-finished");
  }

  void saysWhatWasFoundOfTheScans() {
    Report report = FakeHost::exampleReport();
    finish(report);
    for (const char* name : {"resultProfile", "resultAgreement", "resultPrediction"})
      QVERIFY(!isShown(name));
    report.profile = "The slices look 4 mm thick.";
    report.agreement = "The scans agree.";
    report.prediction = "What lies between the slices was learned.";
    finish(report);
    QCOMPARE(label("resultProfile"), report.profile);
    QCOMPARE(label("resultAgreement"), report.agreement);
    QCOMPARE(label("resultPrediction"), report.prediction);
  }

  void worseThanInterpolationIsSaid() {
    Report report = FakeHost::exampleReport();
    report.quality = {{"gaussians", 29, 0.9}, {"linear", 30.2, 0.92}, {"cubic", 30, 0.91}};
    finish(report);
    QVERIFY(label("qualityVerdict").contains("worse than the best of the others: 1.2 dB less PSNR"));
    QVERIFY(label("qualityVerdict").endsWith("use interpolation for this scan."));
    report.scans = 3; // protocol H says nothing about their combination
    finish(report);
    QVERIFY(label("qualityVerdict").startsWith("Judged on the first scan alone"));
    QVERIFY(!label("qualityVerdict").contains("use interpolation"));
  }

  void measuresThatDisagreeAreBothSaid() {
    Report report = FakeHost::exampleReport();
    report.quality = {{"gaussians", 27.4, 0.838}, {"linear", 27.02, 0.848}, {"cubic", 27.0, 0.852}};
    finish(report);
    QCOMPARE(
        label("qualityVerdict"),
        QString("On held-out slices, InnerGS is better by one measure and worse by the other: "
                "0.4 dB more PSNR than linear interpolation, 0.014 less SSIM than cubic interpolation."));
  }

  void psnrAndSsimCountAlike_data() {
    QTest::addColumn<double>("psnr"); // of InnerGS relative to the others'
    QTest::addColumn<double>("ssim");
    QTest::addColumn<int>("verdict");
    const auto row = [](double psnr, double ssim, Verdict verdict) {
      QTest::addRow("%g dB, %g", psnr, ssim) << psnr << ssim << static_cast<int>(verdict);
    };
    row(0.5, 0.02, Verdict::Better);
    row(0.5, 0.004, Verdict::Better);
    row(0.09, 0.02, Verdict::Better);
    row(0.5, -0.004, Verdict::Better);
    row(0.1, 0, Verdict::Better);
    row(0, 0.005, Verdict::Better);
    row(0.09, 0.004, Verdict::AsGood);
    row(-0.09, -0.004, Verdict::AsGood);
    row(0.5, -0.02, Verdict::Mixed);
    row(-0.5, 0.02, Verdict::Mixed);
    row(-0.5, -0.02, Verdict::Worse);
    row(-0.5, 0.004, Verdict::Worse);
    row(0.09, -0.02, Verdict::Worse);
    row(-0.1, 0, Verdict::Worse);
    row(0, -0.005, Verdict::Worse);
    row(NAN, -0.02, Verdict::Worse);
    row(0.5, NAN, Verdict::Better);
    row(NAN, NAN, Verdict::Unknown);
  }
  void psnrAndSsimCountAlike() {
    QFETCH(double, psnr);
    QFETCH(double, ssim);
    QFETCH(int, verdict);
    // The best of the others is a different method for each measure.
    const QVector<QualityRow> rows{
        {"linear", 30, 0.85}, {"gaussians", 30 + psnr, 0.9 + ssim}, {"cubic", 29, 0.9}};
    QCOMPARE(static_cast<int>(compare(rows).verdict), verdict);
    QCOMPARE(static_cast<int>(compare({rows[0], rows[2]}).verdict), static_cast<int>(Verdict::Unknown));
  }

  void withoutHeldOutSamplesItSaysSo() {
    Report report;
    report.trainingPsnr = 40;
    finish(report);
    QVERIFY(label("heldOutQuality").startsWith("The quality between slices was not judged"));
    QVERIFY(!isShown("qualityTable"));
    QVERIFY(!isShown("resultWarnings"));
    QVERIFY(label("trainingQuality").contains("not held out"));
  }
};

QTEST_MAIN(QualityCardTest)
#include "QualityCardTest.moc"
