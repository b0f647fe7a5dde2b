#include "Core/Job/ReconstructionJob.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Base/StopToken.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/ProgressParts.h"
#include "Core/Job/ReconstructionRun.h"
#include "Core/Job/ScansAsAcquired.h"
#include "Core/Job/SimulatedFit.h"

#include <algorithm>
#include <utility>

namespace innergs {
namespace {

/// Costs of the fit, of the one that judges it, and of those of the simulation, relative to the first.
std::vector<double> partsOf(const ReconstructionInput& input, const Settings& settings) {
  std::vector<double> parts{1, 1 - heldOutFraction(input)};
  if (!input.uncertainty || input.stacks.empty()) return parts;
  try {
    std::for_each(input.stacks.begin(), input.stacks.end(), checkStack);
  } catch (const Error&) { // the run reports it
    return parts;
  }
  const ReconstructionInput simulated = simulatedOutline(input, settings).input;
  const double share = std::min(1.0, voxelsOf(simulated.stacks) / std::max(1.0, voxelsOf(input.stacks)));
  parts.insert(parts.end(), {share, share * (1 - simulated.heldOutFraction)});
  return parts;
}

} // namespace

struct ReconstructionJob::Impl {
  ReconstructionInput input;
  Settings settings;
  ProgressCallback progress;
  std::function<void(const Volume&)> preview;

  void showProfiles(ReconstructionResult& result, const std::stop_token& stop) const;
  void estimate(ReconstructionResult& result, const Volume& second, std::span<const Stack> placed,
                std::span<const HeldOutValue> seen, ProgressParts& parts, const std::stop_token& stop) const;
  /// Judges the result's quality by a second fit with the same settings, and its uncertainty.
  void judge(ReconstructionResult& result, std::span<const Stack> placed, ProgressParts& parts,
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
  checkSettings(job.settings);
  checkHeldOutFraction(job.input.heldOutFraction);
  std::optional<ScansAsAcquired> acquired;
  {
    ThreadPool pool(job.settings.threads);
    pool.setStop(stop);
    try {
      acquired.emplace(job.input, job.settings, pool);
    } catch (const Error& error) { // the run stops at once
      if (error.code() != ErrorCode::Cancelled) throw;
    }
  }
  std::optional<ProgressParts> parts;
  if (heldOutFraction(job.input) > 0) parts.emplace(job.progress, partsOf(job.input, job.settings));
  std::optional<Progress> done; // reported once everything is
  const ProgressCallback untilDone = [&](const Progress& progress) {
    if (progress.phase == Phase::Done)
      done = progress;
    else if (job.progress)
      job.progress(progress);
  };
  ReconstructionResult result;
  std::vector<Stack> placed;
  {
    ReconstructionRun first(job.input, job.settings, false, parts ? parts->next() : untilDone, job.preview);
    result = first.run(stop, renderWhenCancelled);
    if (job.input.uncertainty) placed = first.takeStacks();
  }
  if (!result.cancelled) job.showProfiles(result, stop);
  if (done && job.progress) job.progress(*done);
  if (parts && !result.cancelled) {
    job.judge(result, placed, *parts, stop);
    parts->finish();
  }
  return result;
}

void ReconstructionJob::Impl::showProfiles(ReconstructionResult& result, const std::stop_token& stop) const {
  ThreadPool pool(settings.threads);
  pool.setStop(stop);
  try {
    result.profiles = shownProfiles(input.stacks, pool);
  } catch (const Error& error) { // the result itself is complete
    if (error.code() != ErrorCode::Cancelled) throw;
  }
}

/// Leaves a warning instead where too little is known, or when it fails or is stopped.
void ReconstructionJob::Impl::estimate(ReconstructionResult& result, const Volume& second,
                                       std::span<const Stack> placed, std::span<const HeldOutValue> seen,
                                       ProgressParts& parts, const std::stop_token& stop) const {
  ProgressCallback told = parts.next(Phase::Estimating);
  told({});
  Settings alike = settings;
  alike.iterations = result.settings.iterations;
  alike.ensembleSize = result.settings.ensembleSize;
  const PairFitter fitPair = [&](std::vector<Stack> stacks, const GridGeometry& grid) {
    const auto [simulated, same] =
        simulatedFit(std::move(stacks), grid, result.volume.geometry, input, alike);
    FitPair fitted;
    ReconstructionRun whole(simulated, same, false, told);
    whole.treatPosesAsFound();
    whole.setPredictionShare(result.predictionShare);
    fitted.whole = whole.run(stop, false).volume;
    ReconstructionRun without(simulated, same, true, parts.next(Phase::Estimating));
    without.treatPosesAsFound();
    without.setPredictionShare(result.predictionShare);
    without.keepHeldOutValues();
    ReconstructionResult found = without.run(stop, false);
    throwIfStopped(stop);
    if (found.heldOutSlices > 0) fitted.second = std::move(found.volume);
    fitted.seen = without.takeHeldOutValues();
    return fitted;
  };
  Failure failure;
  try {
    ThreadPool pool(settings.threads);
    pool.setStop(stop);
    result.uncertainty = estimateUncertainty(
        {result.volume, second, placed, result.sliceMotion.moved, seen, result.noise,
         settings.keepBias ? 0 : result.bias.sharedDeviation, fitPair},
        pool);
  } catch (...) {
    failure = failureOf();
  }
  if (failure.sentence.empty()) return;
  result.warnings.push_back(failure.code == ErrorCode::Cancelled
                                ? "Stopped before the uncertainty was known: the result itself is complete."
                            : failure.code == ErrorCode::NoData
                                ? failure.sentence
                                : "The uncertainty could not be estimated. " + failure.sentence);
}

void ReconstructionJob::Impl::judge(ReconstructionResult& result, std::span<const Stack> placed,
                                    ProgressParts& parts, const std::stop_token& stop) {
  const auto begun = std::chrono::steady_clock::now();
  const auto fail = [&](const std::string& why) {
    result.judging = Judging::Failed;
    result.warnings.push_back("The quality could not be judged. " + why);
  };
  if (std::all_of(input.stacks.begin(), input.stacks.end(),
                  [](const Stack& stack) { return stack.image.geometry.size[2] < 3; }))
    return fail("A scan needs at least three slices for one of them to be held out.");
  const auto resume = std::exchange(input.resume, nullptr); // it has seen the slices to be held out
  Failure failure;
  ReconstructionResult found;
  std::vector<HeldOutValue> seen;
  try {
    ReconstructionRun second(input, settings, true, parts.next());
    second.setPredictionShare(result.predictionShare);
    if (input.uncertainty) second.keepHeldOutValues();
    found = second.run(stop, false);
    seen = second.takeHeldOutValues();
  } catch (...) {
    failure = failureOf();
  }
  input.resume = resume;
  if (!failure.sentence.empty()) {
    fail(failure.sentence);
  } else if (found.cancelled) {
    result.judging = Judging::Stopped;
    result.warnings.push_back("Judging the quality was stopped: the result itself is complete.");
  } else if (found.heldOutSlices == 0) {
    fail("The slices held out for it show nothing inside the mask.");
  } else {
    result.judging = Judging::Done;
    result.heldOutPsnr = found.heldOutPsnr;
    result.heldOutSlices = found.heldOutSlices;
    if (input.uncertainty) estimate(result, found.volume, placed, seen, parts, stop);
  }
  result.judgingSeconds = secondsSince(begun);
  result.seconds += result.judgingSeconds;
}

Affine3 slicePlace(const ReconstructionResult& result, std::size_t scan, std::size_t slice) {
  const Affine3 whole = result.alignment.empty() ? Affine3{} : result.alignment[scan].toOthers;
  return result.sliceMotion.moved ? result.sliceMotion.slices[scan][slice].pose * whole : whole;
}

} // namespace innergs
