#pragma once
#include "Core/Job/JobOutline.h"
#include "Widgets/Request.h"

#include <functional>
#include <map>
#include <string>
#include <utility>

namespace innergs::ui {

/// The slow parts of an estimate (asking a driver, timing a small fit), measured on a host's thread one at a
/// time and kept until a reconstruction ends, which tells how long others take. Used on the main thread only.
class ForecastCache {
public:
  /// Runs work on a thread, and on the main thread what it returns, unless the cache is gone by then.
  using Runner = std::function<void(std::function<std::function<void()>()> work)>;
  using Measurement = std::function<JobForecast()>;

  /// changed: fill() may now give more.
  ForecastCache(Runner runner, std::function<void()> changed)
      : runner_(std::move(runner)), changed_(std::move(changed)) {}

  /// Fills in what is known by this key, or begins to measure it; not while a reconstruction is running,
  /// beside which a time means nothing.
  void fill(Estimate& estimate, const std::string& key, const Measurement& measure, bool running);

  ForecastCache(const ForecastCache&) = delete; // what it runs knows its address
  ForecastCache& operator=(const ForecastCache&) = delete;

  void runBegan();
  void runEnded();

private:
  Runner runner_;
  std::function<void()> changed_;
  std::map<std::string, JobForecast> known_;
  bool measuring_ = false;
  int runs_ = 0; // begun and ended: a time measured across one is dropped
};

} // namespace innergs::ui
