#include "Core/Motion/DynamicJob.h"

#include "Core/Base/Error.h"
#include "Core/Base/Hash.h"
#include "Core/Base/NumberText.h"
#include "Core/Fit/Plan.h"
#include "Core/Image/Metrics.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/Resume.h"
#include "Core/Motion/DeformationFit.h"
#include "Core/Motion/IntensityFit.h"
#include "Core/Motion/MotionFit.h"
#include "Core/Render/Render.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

namespace innergs {
namespace {

constexpr double kClearly =
    0.9; // of the other's error: both predict pure noise equally well, and changes cost less
constexpr std::int64_t kTrialReach = 3;  // frames on either side of where most changes
constexpr double kVoxelsPerGaussian = 6; // of moving ones
constexpr std::int64_t kMostGaussians = 1'000'000;
constexpr int kRounds = 35;            // of the joint refinement over all frames
constexpr int kNetworkRounds = 80;     // the same of a deformation network
constexpr double kPreviewInterval = 2; // s, at least

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

std::int64_t gaussiansFor(const TimeSeries& series, const Settings& settings, DynamicKind kind) {
  const auto voxels = static_cast<double>(series.geometry.voxelCount());
  const double each = kind == DynamicKind::Intensity ? 1 : kVoxelsPerGaussian;
  return std::clamp<std::int64_t>(settings.gaussians.value_or(std::llround(voxels / each)), 64,
                                  kMostGaussians);
}

/// Steps of Adam, proportional to the number of frames.
int refinementSteps(const TimeSeries& series, const Settings& settings, int rounds, int fewest) {
  constexpr std::int64_t most = 6000;
  if (settings.rounds)
    return static_cast<int>(std::min<std::int64_t>(*settings.rounds * series.size(), 100'000'000));
  return static_cast<int>(std::clamp<std::int64_t>(rounds * series.size(), fewest, most));
}

MotionPlan motionPlan(const TimeSeries& series, const Settings& settings) {
  MotionPlan plan;
  plan.canonical.gaussians = gaussiansFor(series, settings, DynamicKind::Motion);
  plan.jointSteps = refinementSteps(series, settings, kRounds, 400);
  plan.nodeDistance = settings.nodeDistance.value_or(plan.nodeDistance);
  return plan;
}

DeformationPlan deformationPlan(const TimeSeries& series, const Settings& settings) {
  DeformationPlan plan;
  plan.canonical.gaussians = gaussiansFor(series, settings, DynamicKind::Network);
  plan.steps = refinementSteps(series, settings, kNetworkRounds, 1000);
  plan.times = settings.knots.value_or(0);
  return plan;
}

IntensityPlan intensityPlan(const TimeSeries& series, const Settings& settings) {
  IntensityPlan plan;
  plan.voxelsPerGaussian = static_cast<double>(series.geometry.voxelCount()) /
                           static_cast<double>(gaussiansFor(series, settings, DynamicKind::Intensity));
  plan.coefficients = settings.knots.value_or(0);
  return plan;
}

/// What a stopped fit must agree in to be continued.
std::string keyOf(const TimeSeries& series, const Settings& settings) {
  std::uint64_t h = kHashStart;
  hash(h, &series.geometry, sizeof(GridGeometry));
  hash(h, series.times.data(), series.times.size() * sizeof(double));
  for (const auto& frame : series.frames)
    hash(h, frame.data(), frame.size() * sizeof(float));
  return settingsKey(settings, formatted("%016llx", static_cast<unsigned long long>(h)));
}

IntensityMap mapOf(const TimeSeries& series) {
  const ValueRange range = rangeOf(series);
  return {static_cast<double>(range.high) - static_cast<double>(range.low), static_cast<double>(range.low)};
}

/// The frame whose two neighbours differ most: it shows best whether anything moves.
std::int64_t liveliest(const TimeSeries& series, const ThreadPool& pool) {
  std::int64_t best = series.size() / 2;
  double most = -1;
  for (std::int64_t f = 1; f + 1 < series.size(); ++f) {
    pool.throwIfStopped();
    double sum = 0;
    for (std::size_t v = 0; v < series.frames[f].size(); ++v) {
      const float d = series.frames[f + 1][v] - series.frames[f - 1][v];
      if (std::isfinite(d)) sum += static_cast<double>(d) * static_cast<double>(d);
    }
    if (sum > most) {
      most = sum;
      best = f;
    }
  }
  return best;
}

} // namespace

std::int64_t estimateMemory(const TimeSeries& series, const Settings& settings) {
  const auto voxels = static_cast<std::int64_t>(series.geometry.voxelCount()), frames = series.size();
  const std::int64_t moving = gaussiansFor(series, settings, DynamicKind::Motion),
                     still = gaussiansFor(series, settings, DynamicKind::Intensity);
  const std::int64_t coefficients =
      settings.knots.value_or(static_cast<int>(std::min<std::int64_t>(frames, 256)));
  const std::int64_t motion = frames * voxels * 6 + moving * (16 * 4 * 6 + coefficients * 3 * 4 * 3 + 8 * 8);
  const std::int64_t intensity =
      frames * voxels * 4 + voxels * (4 * 20) + still * (16 * 4 * 3 + coefficients * 4);
  if (settings.kind == DynamicKind::Motion || settings.kind == DynamicKind::Network) return motion;
  return settings.kind == DynamicKind::Intensity ? intensity : std::max(motion, intensity);
}

DynamicJob::DynamicJob(TimeSeries series, Settings settings)
    : series_(std::move(series)), settings_(std::move(settings)) {}

void DynamicJob::show(const DynamicField& field) {
  const double begun = now();
  if (!preview_ || begun < nextPreview_) return;
  preview_(std::make_shared<const DynamicField>(field));
  const double end = now();
  nextPreview_ = end + std::max(kPreviewInterval, 20 * (end - begun));
}

void DynamicJob::report(Phase phase, double fraction, double mse) {
  state_.phase = phase;
  state_.fraction = std::max(state_.fraction, fraction);
  state_.elapsed = now() - start_;
  state_.remaining = state_.fraction > 0.02 ? state_.elapsed * (1 - state_.fraction) / state_.fraction : 0;
  if (mse > 0) state_.trainingPsnr = psnrOf(mse);
  if (device_ && device_->use.id != std::exchange(reportedDevice_, device_->use.id))
    state_.note = device_->use.reason;
  if (progress_) progress_(state_);
  state_.note.clear();
}

/// Keeps small fits on the CPU, and those that only the CPU can do.
void DynamicJob::considerDevice() {
  if (settings_.kind == DynamicKind::Intensity) return leaveDevice();
  const MotionPlan motion = motionPlan(series_, settings_);
  const DeformationPlan network = deformationPlan(series_, settings_);
  const std::int64_t steps =
      settings_.kind == DynamicKind::Network
          ? network.canonical.iterations + network.steps
          : motion.canonical.iterations + motion.trackingSteps * (series_.size() - 1) + motion.jointSteps;
  device_->considerSize(static_cast<double>(series_.geometry.voxelCount()),
                        static_cast<int>(std::min<std::int64_t>(steps, std::numeric_limits<int>::max())));
}

void DynamicJob::leaveDevice() {
  if (!device_->onCpu())
    device_->leave(
        "Gaussians that change their intensity are solved for in one go, which only the CPU does.");
}

DynamicResult DynamicJob::run(std::stop_token stop) {
  start_ = now();
  state_ = {};
  nextPreview_ = 0;
  checkTimeSeries(series_);
  checkSettings(settings_);
  if (settings_.gaussians && (*settings_.gaussians < 1 || *settings_.gaussians > kMostGaussians))
    throw Error(ErrorCode::InvalidArgument,
                "The number of Gaussians must be between 1 and " + std::to_string(kMostGaussians) + ".");
  if (const std::string refusal = memoryRefusal(estimateMemory(series_, settings_), availableMemory());
      !refusal.empty())
    throw Error(ErrorCode::Memory, refusal);
  const KernelSet& kernels = kernelSet(settings_.instructionSet);
  device_.emplace(settings_.device, settings_.instructionSet);
  reportedDevice_.clear();
  ThreadPool pool(settings_.threads);
  pool.setStop(stop);
  DynamicResult result;
  result.settings = settings_;
  result.instructionSet = kernels.name;
  result.threads = pool.threads();
  const bool timed = !series_.sliceTiming.empty();
  if (timed && !settings_.sliceTiming.value_or(true)) series_.sliceTiming = {};
  const std::string key = keyOf(series_, settings_);
  if (resumed_ && (resumed_->state.empty() || resumed_->field.kind == DynamicKind::Intensity))
    throw Error(ErrorCode::InvalidArgument,
                "The model to resume comes from a fit that was not interrupted: there is nothing to resume.");
  if (resumed_ && resumed_->state.key != key)
    throw Error(
        ErrorCode::InvalidArgument,
        "The model to resume was made from another scan or with other settings: use the original ones.");
  if (resumed_ && resumed_->knowsSegments)
    result.notes.push_back(
        "The model to resume has learned segments, which resuming discards: learn them again afterwards.");
  const bool insists = !device_->onCpu() && settings_.device != "auto";
  considerDevice();
  const bool hoped = !device_->onCpu();
  report(Phase::Preparing, 0);
  const IntensityMap map = mapOf(series_);
  const auto share = [&](Phase phase, double from, double to) {
    return [this, phase, from, to](double done, double mse = -1) {
      report(phase, from + (to - from) * done, mse);
    };
  };
  std::unique_ptr<MotionFit> motion;
  std::unique_ptr<DeformationFit> network;
  bool refining = false;
  const auto finish = [&](const DynamicField& field) {
    result.field = std::make_shared<const DynamicField>(field);
    result.trainingPsnr = state_.trainingPsnr;
    if (!refining) return;
    result.state = network ? network->state() : motion->state();
    result.state.key = key;
  };
  const auto refinement = [&](double from, const DynamicField& field) {
    return [&, from, told = share(Phase::Fitting, from, 0.98)](double done, double mse) {
      told(done, mse);
      show(field);
    };
  };
  try {
    std::optional<DynamicKind> given = settings_.kind;
    if (resumed_) given = resumed_->field.kind;
    DynamicKind kind = given.value_or(DynamicKind::Motion);
    std::unique_ptr<IntensityFit> intensity;
    if (!given || kind == DynamicKind::Intensity) {
      intensity =
          std::make_unique<IntensityFit>(series_, map, intensityPlan(series_, settings_), kernels, pool);
      intensity->choose(share(Phase::Initialising, 0, 0.05));
    }
    if (!given) {
      const std::int64_t centre = liveliest(series_, pool);
      const std::int64_t first = std::max<std::int64_t>(0, centre - kTrialReach),
                         last = std::min(series_.size() - 1, centre + kTrialReach);
      std::vector<std::int64_t> window;
      for (std::int64_t f = first; f <= last; ++f)
        window.push_back(f);
      const TimeSeries part = framesOf(series_, window);
      MotionFit trial(part, map, motionPlan(series_, settings_), settings_.seed, kernels, pool, &*device_);
      trial.fitCanonical(share(Phase::Initialising, 0.05, 0.06));
      trial.track(share(Phase::Tracking, 0.06, 0.1));
      double linear = 0, cubic = 0, changed = 0;
      int judged = 0;
      for (std::int64_t f = 1; f + 1 < part.size(); ++f) {
        if (f == trial.middle()) continue; // the canonical field knows it
        linear += trial.predictionErrorBetween(f, false);
        cubic += trial.predictionErrorBetween(f, true);
        changed += intensity->predictionError(first + f);
        ++judged;
      }
      if (judged > 0) {
        const double moved = std::min(linear, cubic);
        kind = moved < kClearly * changed ? DynamicKind::Motion : DynamicKind::Intensity;
        result.choice = std::string("Gaussians ") +
                        (kind == DynamicKind::Motion ? "move" : "stay in place and change their intensity") +
                        ": where the frames change most, moving ones predicted held-out frames with " +
                        formatted("%.2f", psnrOf(moved / judged)) + " dB, changing ones with " +
                        formatted("%.2f", psnrOf(changed / judged)) + " dB.";
      }
      if (kind == DynamicKind::Motion) intensity.reset();
    }
    result.settings.kind = kind;
    if (kind == DynamicKind::Intensity) leaveDevice();
    result.slicesTimed = kind == DynamicKind::Intensity && !series_.sliceTiming.empty();
    if (timed && !result.slicesTimed && kind != DynamicKind::Intensity)
      result.notes.push_back("The slices of a frame were acquired at different times; where Gaussians move, "
                             "each frame is treated as acquired at its start.");
    if (kind == DynamicKind::Intensity) {
      intensity->solve(share(Phase::Fitting, 0.1, 0.98));
      finish(intensity->field());
    } else if (kind == DynamicKind::Network) {
      network = std::make_unique<DeformationFit>(series_, map, deformationPlan(series_, settings_),
                                                 settings_.seed, kernels, pool, &*device_);
      if (resumed_)
        network->resume(resumed_->field, resumed_->state);
      else
        network->fitCanonical(share(Phase::Initialising, 0, 0.05));
      result.steps = deformationPlan(series_, settings_).steps;
      refining = true;
      network->refine(refinement(0.05, network->field()));
      finish(network->field());
    } else {
      motion = std::make_unique<MotionFit>(series_, map, motionPlan(series_, settings_), settings_.seed,
                                           kernels, pool, &*device_);
      if (resumed_) {
        motion->resume(resumed_->field, resumed_->state);
      } else {
        motion->fitCanonical(share(Phase::Initialising, 0.1, 0.15));
        motion->track(share(Phase::Tracking, 0.15, 0.5));
        motion->useSpline(settings_.knots ? *settings_.knots : motion->chooseCoefficients());
      }
      result.steps = motionPlan(series_, settings_).jointSteps;
      refining = true;
      motion->refine(refinement(0.5, motion->field()));
      finish(motion->field());
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::Cancelled) throw;
    result.cancelled = true;
    if (refining) finish(network ? network->field() : motion->field());
  }
  if (result.field && !result.cancelled) {
    double squared = 0;
    std::int64_t samples = 0;
    TimeSeries grid{series_.geometry, {}, {}, {}, {}};
    if (result.slicesTimed) grid.sliceTiming = series_.sliceTiming;
    RenderOptions options;
    options.threads = settings_.threads;
    options.instructionSet = settings_.instructionSet;
    options.stop = stop;
    try {
      for (std::int64_t f = 0; f < series_.size(); ++f) {
        const std::vector<float> rendered = acquiredFrame(*result.field, grid, series_.times[f], options);
        for (std::size_t v = 0; v < rendered.size(); ++v) {
          const double d =
              (static_cast<double>(rendered[v]) - static_cast<double>(series_.frames[f][v])) / map.scale;
          if (!std::isfinite(d)) continue;
          squared += d * d;
          ++samples;
        }
      }
      result.trainingPsnr = psnrOf(squared / static_cast<double>(std::max<std::int64_t>(1, samples)));
    } catch (const Error& error) {
      if (error.code() != ErrorCode::Cancelled) throw;
      result.cancelled = true;
    }
  }
  result.device = device_->use;
  // With "auto", changing intensities need no note: only the CPU solves for them.
  if (device_->onCpu() && (insists || (hoped && result.settings.kind != DynamicKind::Intensity)))
    result.notes.push_back(device_->use.reason);
  result.seconds = now() - start_;
  if (!result.cancelled) report(Phase::Done, 1);
  return result;
}

} // namespace innergs
