#include "Evaluation/JudgedReconstruction.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "Core/Fit/Plan.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/ProgressParts.h"
#include "Core/Job/SimulatedFit.h"
#include "Evaluation/HeldOutProtocol.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace innergs {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kInterpolations = 3;             // compared by protocol H
constexpr double kInterpolationIterations = 5; // approximate cost of interpolating and scoring a voxel
constexpr double kCoarseIteration = 0.15;      // relative to an iteration at full resolution

/// Whether protocol H can hold out slices of the first stack: at poses of their own nothing can be
/// interpolated between them.
bool hasGrid(const ReconstructionInput& input) {
  return input.stacks.front().poses.empty();
}

/// Samples times iterations.
double costOf(const ReconstructionInput& fit, Settings settings) {
  DataTraits traits = geometryTraits(fit.stacks);
  const Vec3 extent = fit.stacks.front().image.geometry.extent();
  traits.volume = extent[0] * extent[1] * extent[2];
  const FitPlan plan = makePlan(settings, traits);
  double samples = 0;
  for (const Stack& stack : fit.stacks)
    samples += static_cast<double>(stack.image.geometry.voxelCount());
  return samples * *settings.ensembleSize *
         (plan.iterations - (1 - kCoarseIteration) * plan.coarseIterations);
}

/// Costs of the fits, the one that protocol H scores, and its interpolations.
std::vector<double> costs(const ReconstructionInput& input, const Settings& settings, int keepEvery) {
  try {
    for (const Stack& stack : input.stacks)
      checkGeometry(stack.image.geometry, "The stack");
    const GridGeometry& first = input.stacks.front().image.geometry;
    const double heldOut = heldOutFraction(input);
    double job = (heldOut > 0 ? 2 - heldOut : 1) * costOf(input, settings);
    if (input.uncertainty) {
      const SimulatedFit simulated = simulatedOutline(input, settings);
      job += (2 - simulated.input.heldOutFraction) * costOf(simulated.input, simulated.settings);
    }
    if (!hasGrid(input)) return {job, 0, 0};
    return {job, costOf(keptOutline(first, keepEvery, 2), settings),
            kInterpolationIterations * static_cast<double>(first.voxelCount())};
  } catch (const Error&) { // the fits will throw it too
    return {1, 1, 1};
  }
}

} // namespace

JudgedReconstruction::JudgedReconstruction(ReconstructionInput input, Settings settings,
                                           std::optional<int> keepEvery)
    : input_(std::move(input)), settings_(std::move(settings)), keepEvery_(keepEvery) {}

JudgedResult JudgedReconstruction::run(const std::stop_token& stop, bool renderWhenCancelled) {
  if (keepEvery_) checkKeepEvery(*keepEvery_);
  JudgedResult judged;
  ReconstructionResult& result = judged.reconstruction;
  if (!keepEvery_ || input_.stacks.empty()) {
    ReconstructionJob job(std::move(input_), settings_);
    job.onProgress(progress_);
    job.onPreview(preview_);
    result = job.run(stop, renderWhenCancelled);
    return judged;
  }

  checkSettings(settings_);
  ProgressParts parts(progress_, costs(input_, settings_, *keepEvery_));
  EvaluationOptions options;
  options.settings = settings_;
  options.stop = stop;
  Volume volume;
  const bool judgeable = hasGrid(input_);
  {
    ReconstructionJob job(std::move(input_), settings_);
    job.onProgress(parts.next());
    job.onPreview(preview_);
    result = job.run(stop, renderWhenCancelled);
    if (result.cancelled) return judged;
    ReconstructionInput input = job.takeInput();
    Stack& scan = input.stacks.front();
    if (!input.masks.empty()) options.mask = std::move(input.masks.front());
    if (settings_.n4) { // judges on the corrected scan
      if (options.mask) scan.observed = resampleMask(*options.mask, scan.image.geometry, stop);
      input.n4(scan, options.mask.has_value(), stop);
      options.settings.n4 = false;
    }
    volume = std::move(scan.image);
  }

  const auto begun = Clock::now();
  std::optional<Clock::time_point> interpolating;
  options.progress = parts.next();
  ProgressCallback compared;
  int methods = 0;
  options.onMethod = [&](const std::string& name) {
    if (name == "gaussians") return; // reports itself
    if (!interpolating) {
      interpolating = Clock::now();
      compared = parts.next();
    }
    Progress progress;
    progress.fraction = std::min(1.0, static_cast<double>(methods++) / kInterpolations);
    progress.elapsed = secondsSince(*interpolating);
    compared(progress);
  };
  HeldOutCase heldOut;
  heldOut.factor = *keepEvery_;
  heldOut.axis = 2; // a stack counts its slices along K
  try {
    if (!judgeable)
      throw Error(ErrorCode::Geometry,
                  "Each slice of the first scan lies at a pose of its own, so there is no "
                  "interpolation to compare with: hold out slices instead.");
    judged.quality = evaluateHeldOut(volume, heldOut, options);
    if (result.judging == Judging::NotAsked) result.judging = Judging::Done;
  } catch (...) {
    const Failure failure = failureOf();
    const bool stopped = failure.code == ErrorCode::Cancelled;
    if (!stopped)
      result.warnings.push_back("The quality could not be judged. " + failure.sentence);
    else if (result.judging != Judging::Stopped) // that case is reported already
      result.warnings.push_back("Judging the quality was stopped: the result itself is complete.");
    result.judging = stopped ? Judging::Stopped : Judging::Failed;
  }
  const double seconds = secondsSince(begun);
  result.judgingSeconds += seconds;
  result.seconds += seconds;
  parts.finish();
  return judged;
}

void checkKeepEvery(int keepEvery) {
  if (keepEvery != 0 && (keepEvery < 2 || keepEvery > 64))
    throw Error(ErrorCode::InvalidArgument,
                "Judging the quality keeps every 2nd to 64th slice: choose a number "
                "from 2 to 64, or 0 for the usual one.");
}

std::vector<ReconstructionInput> fitOutlines(const ReconstructionInput& input, std::optional<int> keepEvery) {
  std::vector<ReconstructionInput> fits{input};
  if (keepEvery && hasGrid(input))
    fits.push_back(keptOutline(input.stacks.front().image.geometry, *keepEvery, 2));
  return fits;
}

} // namespace innergs
