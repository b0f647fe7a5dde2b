#include "Evaluation/JudgedSeries.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Evaluation/ExperimentDynamic.h"

#include <algorithm>
#include <chrono>

namespace innergs {
namespace {

constexpr std::int64_t kPapers = 8;        // every 8th frame is held out, as the paper does
constexpr std::int64_t kFewestToJudge = 6; // frames

} // namespace

JudgedSeries::JudgedSeries(TimeSeries series, Settings settings, bool judge)
    : series_(std::move(series)), settings_(std::move(settings)), judge_(judge) {}

JudgedSeriesResult JudgedSeries::run(const std::stop_token& stop) {
  const auto start = std::chrono::steady_clock::now();
  const bool judging = judge_ && series_.size() >= kFewestToJudge;
  const double first = judging ? 0.5 : 1; // of the work
  const auto tell = [&](Progress progress, double from, double to) {
    progress.fraction = from + (to - from) * progress.fraction;
    progress.elapsed = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    progress.remaining =
        progress.fraction > 0.02 ? progress.elapsed * (1 - progress.fraction) / progress.fraction : 0;
    if (progress_) progress_(progress);
  };
  JudgedSeriesResult outcome;
  DynamicJob job(series_, settings_);
  if (resumed_) job.resume(resumed_);
  job.onProgress([&](Progress progress) {
    if (judging && progress.phase == Phase::Done) progress.phase = Phase::Judging;
    tell(std::move(progress), 0, first);
  });
  job.onPreview(preview_);
  outcome.result = job.run(stop);
  if (judge_ && !judging)
    outcome.note = "There are too few frames to hold out some and judge the quality on them.";
  if (!judging || outcome.result.cancelled || !outcome.result.field) return outcome;
  DynamicExperiment experiment;
  experiment.series = std::move(series_);
  experiment.name = experiment.series.name;
  experiment.every = std::clamp<std::int64_t>(experiment.series.size() / 3, 2, kPapers);
  experiment.settings = settings_;
  experiment.stop = stop;
  const double reached = outcome.result.trainingPsnr;
  experiment.progress = [&](Progress progress) {
    if (progress.phase != Phase::Done) progress.phase = Phase::Judging;
    progress.trainingPsnr = reached;
    progress.note.clear(); // where the first fit ran is already reported
    tell(std::move(progress), first, 1);
  };
  try {
    outcome.quality = judgeFrames(experiment);
    outcome.judging = Judging::Done;
  } catch (...) {
    const Failure failure = failureOf();
    outcome.judging = failure.code == ErrorCode::Cancelled ? Judging::Stopped : Judging::Failed;
    outcome.note = outcome.judging == Judging::Stopped
                       ? "Judging the quality was stopped; the result is complete."
                       : "The quality could not be judged: " + failure.sentence;
  }
  return outcome;
}

} // namespace innergs
