#pragma once
#include "Core/Motion/DynamicJob.h"
#include "Evaluation/Protocols.h"

#include <optional>

namespace innergs {

/// The outcome of JudgedSeries: a continuous volume in space and time, and the quality that the same settings
/// reach on frames that a second fit does not see.
struct JudgedSeriesResult {
  DynamicResult result; // of all frames
  Judging judging = Judging::NotAsked;
  std::optional<EvaluationReport> quality; // with Judging::Done
  std::string note;                        // why there is none, a sentence
};

/// A dynamic job, and on request a second one without every few frames that judges the quality.
class JudgedSeries {
public:
  JudgedSeries(TimeSeries series, Settings settings, bool judge);

  /// The first fit continues from there, as DynamicJob::resume() does.
  void resume(std::shared_ptr<const StoppedDynamicFit> fit) { resumed_ = std::move(fit); }
  /// Remaining time and fraction cover both fits.
  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }

  void onPreview(std::function<void(std::shared_ptr<const DynamicField>)> callback) {
    preview_ = std::move(callback);
  }

  /// Blocks. A stop before the first fit is complete ends as DynamicJob's does; after it, only the judging
  /// ends. Throws as DynamicJob does.
  JudgedSeriesResult run(const std::stop_token& stop = {});

private:
  TimeSeries series_;
  Settings settings_;
  bool judge_;
  std::shared_ptr<const StoppedDynamicFit> resumed_;
  ProgressCallback progress_;
  std::function<void(std::shared_ptr<const DynamicField>)> preview_;
};

} // namespace innergs
