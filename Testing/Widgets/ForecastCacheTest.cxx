#include "Widgets/ForecastCache.h"

#include <QTest>

#include <stdexcept>

using namespace innergs;
using namespace innergs::ui;

/// Measurements that end when the test lets them.
class ForecastCacheTest : public QObject {
  Q_OBJECT

  std::vector<std::function<std::function<void()>()>> works_;
  int measured_ = 0, changed_ = 0;

  ForecastCache cache() {
    return {[this](const auto& work) { works_.push_back(work); }, [this] { ++changed_; }};
  }
  double seconds(ForecastCache& cache, const std::string& key = "a", bool running = false) {
    Estimate estimate;
    const auto measure = [this] { return JobForecast{"", "CPU", "On the CPU.", 1.0 * ++measured_}; };
    cache.fill(estimate, key, measure, running);
    return estimate.seconds;
  }
  void endMeasurement() {
    QCOMPARE(works_.size(), std::size_t(1));
    works_.front()()();
    works_.clear();
  }

private Q_SLOTS:
  void init() {
    works_.clear();
    measured_ = changed_ = 0;
  }

  void measuresOneAtATimeAndKeepsIt() {
    ForecastCache forecasts = cache();
    QCOMPARE(seconds(forecasts), 0.0);
    QCOMPARE(seconds(forecasts, "b"), 0.0);
    endMeasurement();
    QCOMPARE(changed_, 1);
    QCOMPARE(seconds(forecasts), 1.0);
    QCOMPARE(seconds(forecasts, "a", true), 1.0);
    QVERIFY(works_.empty());
    QCOMPARE(seconds(forecasts, "b"), 0.0);
    endMeasurement();
    QCOMPARE(seconds(forecasts, "b"), 2.0);
  }

  void aTimeBesideAReconstructionIsDropped() {
    ForecastCache forecasts = cache();
    QCOMPARE(seconds(forecasts), 0.0);
    forecasts.runBegan();
    endMeasurement();
    QCOMPARE(changed_, 1);
    QCOMPARE(seconds(forecasts, "a", true), 0.0);
    QVERIFY(works_.empty());
    forecasts.runEnded();
    QCOMPARE(seconds(forecasts), 0.0);
    endMeasurement();
    QCOMPARE(seconds(forecasts), 2.0);
    forecasts.runEnded(); // it tells how long others take
    QCOMPARE(seconds(forecasts), 0.0);
  }

  void whatAMeasurementThrowsIsTheReason() {
    ForecastCache forecasts = cache();
    Estimate estimate;
    const auto measure = []() -> JobForecast { throw std::runtime_error("broken"); };
    forecasts.fill(estimate, "a", measure, false);
    endMeasurement();
    forecasts.fill(estimate, "a", measure, false);
    QVERIFY(estimate.reason.contains("broken"));
    QVERIFY(works_.empty());
  }
};

QTEST_MAIN(ForecastCacheTest)
#include "ForecastCacheTest.moc"
