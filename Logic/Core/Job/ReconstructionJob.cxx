#include "Core/Job/ReconstructionJob.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Job/ProgressParts.h"
#include "Core/Job/ReconstructionRun.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs {

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing:
    return "Preparing";
  case Phase::Aligning:
    return "Aligning scans and slices";
  case Phase::Predicting:
    return "Predicting between slices";
  case Phase::Initialising:
    return "Placing Gaussians";
  case Phase::Tracking:
    return "Tracking frames";
  case Phase::Fitting:
    return "Fitting";
  case Phase::Refining:
    return "Refining";
  case Phase::Rendering:
    return "Rendering";
  case Phase::Judging:
    return "Judging the quality (second fit)";
  case Phase::Done:
    return "Done";
  }
  return "";
}

namespace {

constexpr double kUsualFraction = 0.2; // of the slices, withheld for the uncertainty; likewise of its twin's

} // namespace

struct ReconstructionJob::Impl {
  ReconstructionInput input;
  Settings settings;
  ProgressCallback progress;
  std::function<void(const Volume&)> preview;

  std::optional<Uncertainty> estimated(ReconstructionResult& result, const Volume& second,
                                       std::span<const Stack> placed, std::span<const WithheldValue> seen,
                                       const std::stop_token& stop) const;
  /// Measures the result's quality by a second fit with the same settings.
  void judge(ReconstructionResult& result, std::span<const Stack> placed, const ProgressCallback& told,
             const std::stop_token& stop);
};

ReconstructionJob::ReconstructionJob(ReconstructionInput input, Settings settings)
    : impl_(std::make_unique<Impl>()) {
  impl_->input = std::move(input);
  impl_->settings = std::move(settings);
}
ReconstructionJob::~ReconstructionJob() = default;
void ReconstructionJob::onProgress(ProgressCallback callback) {
  impl_->progress = std::move(callback);
}
void ReconstructionJob::onPreview(std::function<void(const Volume&)> callback) {
  impl_->preview = std::move(callback);
}
ReconstructionInput ReconstructionJob::takeInput() {
  return std::exchange(impl_->input, {});
}
ReconstructionResult ReconstructionJob::run(std::stop_token stop, bool renderWhenCancelled) {
  Impl& job = *impl_;
  if (job.input.uncertainty && job.input.heldOutFraction == 0) job.input.heldOutFraction = kUsualFraction;
  const double fraction = job.input.heldOutFraction;
  checkHeldOutFraction(fraction);
  std::optional<ProgressParts> parts;
  if (fraction > 0) parts.emplace(job.progress, std::vector<double>{1, 1 - fraction});
  ReconstructionResult result;
  std::vector<Stack> placed;
  {
    ReconstructionRun first(job.input, job.settings, false, parts ? parts->next() : job.progress,
                            job.preview);
    result = first.run(stop, renderWhenCancelled);
    if (job.input.uncertainty) placed = first.takeStacks();
  }
  if (parts && !result.cancelled) {
    job.judge(result, placed, parts->next(), stop);
    parts->finish();
  }
  return result;
}

/// Nothing, with a warning, where too little is known for it.
std::optional<Uncertainty> ReconstructionJob::Impl::estimated(ReconstructionResult& result,
                                                              const Volume& second,
                                                              std::span<const Stack> placed,
                                                              std::span<const WithheldValue> seen,
                                                              const std::stop_token& stop) const {
  ThreadPool pool(settings.threads);
  pool.setStop(stop);
  const FitTwice twin = [&](std::vector<Stack> stacks, const GridGeometry& grid) {
    ReconstructionInput simulated;
    simulated.stacks = std::move(stacks);
    simulated.outputGrid = grid;
    simulated.uncertainty = true;
    simulated.heldOutFraction = std::max(input.heldOutFraction, kUsualFraction);
    Settings same = settings;
    same.align = false;
    same.sliceMotion = SliceMotionKind::Off;
    if (same.gaussians) {
      const auto& [x, y, z] = grid.extent();
      const auto& [a, b, c] = result.volume.geometry.extent();
      const double share = std::min(1.0, x * y * z / (a * b * c));
      same.gaussians = std::max<std::int64_t>(1, std::llround(share * static_cast<double>(*same.gaussians)));
    }
    FittedTwice fitted;
    fitted.whole = ReconstructionRun(simulated, same, false, {}).run(stop, false).volume;
    ReconstructionRun second(simulated, same, true, {});
    ReconstructionResult found = second.run(stop, false);
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "Stopped on request.");
    if (found.heldOutSlices > 0) fitted.second = std::move(found.volume);
    fitted.seen = second.withheldValues();
    return fitted;
  };
  try {
    return estimateUncertainty({result.volume, second, placed, seen, result.noise, twin}, pool);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::NoData && error.code() != ErrorCode::Cancelled) throw;
    result.warnings.push_back(
        error.code() == ErrorCode::NoData
            ? error.what()
            : "Stopped before the uncertainty was known: the result itself is complete.");
  }
  return {};
}

void ReconstructionJob::Impl::judge(ReconstructionResult& result, std::span<const Stack> placed,
                                    const ProgressCallback& told, const std::stop_token& stop) {
  const auto begun = std::chrono::steady_clock::now();
  const auto fail = [&](const std::string& why) {
    result.judging = Judging::Failed;
    result.warnings.push_back("The quality could not be judged. " + why);
  };
  if (std::all_of(input.stacks.begin(), input.stacks.end(),
                  [](const Stack& stack) { return stack.image.geometry.size[2] < 3; }))
    return fail("A scan needs at least three slices for one of them to be withheld.");
  const auto resume = std::exchange(input.resume, nullptr); // it has seen the slices to be withheld
  Failure failure;
  ReconstructionResult found;
  try {
    ReconstructionRun second(input, settings, true, told);
    found = second.run(stop, false);
    if (input.uncertainty && !found.cancelled && found.heldOutSlices > 0)
      result.uncertainty = estimated(result, found.volume, placed, second.withheldValues(), stop);
  } catch (...) {
    failure = failureOf();
  }
  input.resume = resume;
  if (!failure.sentence.empty()) {
    fail(failure.sentence);
  } else if (found.cancelled) {
    result.judging = Judging::Stopped;
    result.warnings.push_back("The judging of the quality was stopped: the result itself is complete.");
  } else if (found.heldOutSlices == 0) {
    fail("The slices withheld for it show nothing inside the mask.");
  } else {
    result.judging = Judging::Done;
    result.heldOutPsnr = found.heldOutPsnr;
    result.heldOutSlices = found.heldOutSlices;
  }
  result.judgingSeconds = secondsSince(begun);
  result.seconds += result.judgingSeconds;
}

} // namespace innergs
