#include "Widgets/ForecastCache.h"

#include "Core/Base/Failure.h"

namespace innergs::ui {

void ForecastCache::fill(Estimate& estimate, const std::string& key, const Measurement& measure,
                         bool running) {
  if (const auto found = known_.find(key); found != known_.end()) {
    estimate.refusal = QString::fromStdString(found->second.refusal);
    estimate.reason = QString::fromStdString(found->second.reason);
    estimate.seconds = found->second.seconds;
    return;
  }
  if (measuring_ || running) return;
  measuring_ = true;
  runner_([this, key, measure, run = runs_]() -> std::function<void()> {
    JobForecast forecast;
    const std::string problem = sentenceOf([&] { forecast = measure(); });
    if (!problem.empty()) forecast.reason = problem;
    return [this, key, forecast, run] {
      measuring_ = false;
      if (run == runs_) known_[key] = forecast;
      changed_();
    };
  });
}

void ForecastCache::runBegan() {
  ++runs_;
}

void ForecastCache::runEnded() {
  ++runs_;
  known_.clear();
}

} // namespace innergs::ui
