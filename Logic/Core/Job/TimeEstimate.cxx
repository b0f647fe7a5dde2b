#include "Core/Job/TimeEstimate.h"

#include "Core/Base/Elapsed.h"
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/Parallel.h"
#include "Core/Fit/Plan.h"
#include "Core/Image/NoiseEstimate.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/PredictionPlan.h"
#include "Core/Job/ReconstructionRun.h"
#include "Core/Job/Resume.h"
#include "Core/Job/ShareTrial.h"
#include "Core/Job/SimulatedFit.h"
#include "Core/Prediction/CandidateGrid.h"
#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/PredictionNoise.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <limits>

namespace innergs {
namespace {

constexpr double kFewVoxels = 12e3, kMoreVoxels = 96e3; // of the timed job
constexpr double kTooShort = 0.006;                     // seconds; below: timed again with more voxels
constexpr std::int64_t kMostOutput = 200'000;           // voxels that the timed job renders
constexpr double kOld = 60;                             // seconds; after: timed again, as the load changes
constexpr int kFewIterations = 20;                      // too few to measure a device's speed
constexpr double kPlacing = 6e3; // likewise for several scans in masks, per voxel of the domain
/// Cost in voxels for which an iteration of the fit takes as long: of aligning two scans and of comparing
/// their shading, per point compared; of the search for motion between slices, per voxel, if they lie still
/// or moved.
constexpr double kAligning = 30, kShading = 15, kStillSlices = 6, kMovedSlices = 30;
/// Cost of an iteration and of the refinement where slices move, relative to still ones.
constexpr double kMovedFit = 1.6, kMovedRefining = 1.5;
constexpr double kAlignedPoints = 40e3;
constexpr double kAlignedVoxel = 8e3; // cost of such a voxel, in multiply-adds, where a prediction is fitted
constexpr int kTrialIterations = 4;   // at most half of them coarse

/// A piece of the stacks' grids with about this many voxels, all around one point, with some structure.
std::vector<Stack> pieceOf(const std::vector<Stack>& stacks, double voxels) {
  double perMm3 = 0, side = 0;
  for (const Stack& stack : stacks) {
    const Vec3& s = stack.image.geometry.spacing;
    perMm3 += 1 / (s[0] * s[1] * s[2]);
    side = std::max(side, 4 * s[2]);
  }
  side = std::max(side, std::cbrt(voxels / perMm3));
  std::vector<Stack> piece;
  for (const Stack& stack : stacks) {
    Stack part;
    part.thickness = stack.thickness;
    part.profile = stack.profile;
    part.pixelWidth = stack.pixelWidth;
    GridGeometry& g = part.image.geometry;
    g = stack.image.geometry;
    Vec3 middle;
    for (int a = 0; a < 3; ++a) {
      g.size[a] = std::clamp<std::int64_t>(std::llround(side / g.spacing[a]), 2,
                                           std::max<std::int64_t>(2, g.size[a]));
      middle[a] = 0.5 * (static_cast<double>(g.size[a]) - 1) * g.spacing[a];
    }
    g.origin = -1.0 * (g.direction * middle);
    part.image.voxels.reserve(static_cast<std::size_t>(g.voxelCount()));
    const Affine3 map = g.indexToWorld();
    const double wave = 2 * 3.14159265 / (12 * g.spacing[0]);
    for (std::int64_t k = 0; k < g.size[2]; ++k)
      for (std::int64_t j = 0; j < g.size[1]; ++j)
        for (std::int64_t i = 0; i < g.size[0]; ++i) {
          const Vec3 x = map({double(i), double(j), double(k)});
          part.image.voxels.push_back(
              static_cast<float>(std::sin(wave * x[0]) + std::sin(wave * x[1]) + std::sin(wave * x[2])));
        }
    piece.push_back(std::move(part));
  }
  return piece;
}

/// The grid at this spacing, or at a wider one if that were too much to render.
GridGeometry smallOutput(const GridGeometry& part, Vec3 spacing) {
  const Vec3 extent = part.extent();
  double voxels = 1;
  for (int a = 0; a < 3; ++a)
    voxels *= std::max(1.0, extent[a] / spacing[a]);
  spacing = std::max(1.0, std::cbrt(voxels / kMostOutput)) * spacing;
  GridGeometry grid = withSpacing(part, spacing);
  while (grid.voxelCount() > kMostOutput)
    grid = withSpacing(part, spacing = 1.1 * spacing);
  return grid;
}

TrialTimes timeTrial(ReconstructionInput small, const Settings& settings, int coarse) {
  TrialTimes t;
  double iterations[kTrialIterations] = {}, fitted = 0, rendering = 0, last = 0;
  ReconstructionJob job(std::move(small), settings);
  job.onProgress([&](const Progress& p) {
    if (p.phase == Phase::Fitting && p.iteration > 0 && p.iteration <= kTrialIterations) {
      iterations[p.iteration - 1] = p.elapsed - last;
      if (p.iteration == 1) t.start = p.elapsed;
      fitted = p.elapsed;
    }
    if (p.phase == Phase::Rendering) rendering = p.elapsed;
    if (p.phase == Phase::Done) t.total = p.elapsed;
    last = p.elapsed;
  });
  job.run();
  // The first iteration includes one-time costs; the fastest of several is the least disturbed.
  t.fine = *std::min_element(iterations + coarse, iterations + kTrialIterations);
  t.coarse = coarse > 0 ? *std::min_element(iterations, iterations + coarse) : t.fine;
  t.start = std::max(0.0, t.start - t.coarse);
  t.refine = std::max(0.0, rendering - fitted);
  t.render = std::max(0.0, t.total - rendering);
  return t;
}

/// What a timing depends on, apart from the machine.
std::string keyOf(const ReconstructionInput& input, const Settings& filled, const GridGeometry& output) {
  Settings settings = filled;
  settings.iterations = kTrialIterations;
  settings.ensembleSize = 1;
  settings.seed = 1;
  std::string grids;
  const auto add = [&](double x) { grids += formatted("%.17g ", x); };
  for (const Stack& stack : input.stacks) {
    add(stack.thickness);
    add(static_cast<double>(stack.profile));
    add(stack.pixelWidth);
    for (int a = 0; a < 3; ++a) {
      add(stack.image.geometry.spacing[a]);
      add(static_cast<double>(stack.image.geometry.size[a]));
    }
  }
  for (const double s : output.spacing)
    add(s);
  return settingsKey(settings, grids) + settings.instructionSet + std::to_string(settings.threads) +
         std::to_string(settings.consistency);
}

/// Whether slices are moved whatever the scans show. `auto` decides only during the run; until then they
/// count as still, the usual case.
bool moves(const std::vector<Stack>& stacks, const Settings& settings) {
  return settings.sliceMotion == SliceMotionKind::On && correctsSlices(settings, stacks);
}

bool haveVoxels(const std::vector<Stack>& stacks) {
  return std::none_of(stacks.begin(), stacks.end(), [](const Stack& s) { return s.image.voxels.empty(); });
}

/// Whether a scan, if its voxels are here, is so noisy that its prediction is averaged with a field.
bool averagesWithField(const Stack& scan, const GridGeometry& grid, const Settings& settings) {
  const auto may = [&](double noise) {
    return fieldShareOfNoisy(scan, settings, noise, grid.voxelCount()) > 0;
  };
  return !scan.image.voxels.empty() && may(1) &&
         may(unpredictedNoise(scan, estimateNoise(scan.image, scan.observed)) /
             chooseIntensityMap({&scan, 1}).scale);
}

/// Voxels for which an iteration of the fit takes as long as aligning the scans.
double aligningVoxels(const std::vector<Stack>& stacks, const Settings& settings, double voxels) {
  double count = !correctsSlices(settings, stacks)
                     ? 0
                     : voxels * (moves(stacks, settings) ? kMovedSlices : kStillSlices);
  const bool shading = settings.align || settings.biasField != BiasFieldKind::Off; // at least looked for
  const double perPoint = (settings.align ? kAligning : 0) + (shading ? kShading : 0);
  if (perPoint > 0)
    for (const Stack& stack : stacks)
      count += perPoint * std::min(kAlignedPoints, static_cast<double>(stack.image.geometry.voxelCount())) *
               static_cast<double>(stacks.size() - 1);
  return count;
}

/// The fastest of several products like those of a network of 32 channels.
double timeMultiply(const std::string& instructionSet) {
  constexpr std::int64_t rows = 48, depth = 96, columns = 32;
  constexpr int products = 40, trials = 5;
  const std::vector<float> a(static_cast<std::size_t>(rows * depth), 1.f),
      b(static_cast<std::size_t>(depth * columns), 1e-3f);
  std::vector<float> c(static_cast<std::size_t>(rows * columns), 0.f);
  const NetworkKernels& kernels = networkKernels(instructionSet);
  double fastest = std::numeric_limits<double>::infinity();
  for (int trial = 0; trial < trials; ++trial) {
    const auto start = std::chrono::steady_clock::now();
    for (int n = 0; n < products; ++n)
      kernels.multiply({rows, depth, columns, a.data(), depth, 1, b.data(), c.data()});
    fastest = std::min(fastest, secondsSince(start));
  }
  return fastest / (static_cast<double>(products) * rows * depth * columns);
}

TimeEstimator& estimator() {
  static TimeEstimator only(timeTrial, timeMultiply);
  return only;
}

} // namespace

TimeEstimator::Timing TimeEstimator::timed(const ReconstructionInput& input, const Settings& filled,
                                           const GridGeometry& output, double voxels) const {
  ReconstructionInput small;
  small.stacks = pieceOf(input.stacks, voxels);
  const DataTraits traits = geometryTraits(small.stacks);
  small.outputGrid = smallOutput(small.stacks.front().image.geometry, output.spacing);
  Settings settings = filled;
  settings.device = "cpu";
  settings.iterations = kTrialIterations;
  settings.ensembleSize = 1;
  settings.align = false; // a fixed part of it, which a small piece would overrate
  settings.biasField = BiasFieldKind::Off;
  settings.n4 = false;
  settings.sliceMotion = SliceMotionKind::Off;
  settings.prediction = PredictionKind::None;
  const double share = traits.volume / geometryTraits(input.stacks).volume;
  const auto scaled = [&](std::int64_t count) {
    return std::max<std::int64_t>(8, std::llround(share * static_cast<double>(count)));
  };
  settings.gaussians = scaled(*filled.gaussians);
  settings.maxGaussians = std::max(*settings.gaussians, scaled(*filled.maxGaussians));
  Timing timing;
  timing.voxels = voxelsOf(small.stacks);
  timing.outputVoxels = static_cast<double>(small.outputGrid->voxelCount());
  timing.disturbed = runningJobs() > 0;
  Settings again = settings;
  timing.times = trial_(std::move(small), settings, makePlan(again, traits).coarseIterations);
  timing.disturbed = timing.disturbed || runningJobs() > 0;
  timing.when = std::chrono::steady_clock::now();
  return timing;
}

TimeEstimator::Timing TimeEstimator::timingOf(const ReconstructionInput& input, const Settings& filled,
                                              const GridGeometry& output) {
  const std::string key = keyOf(input, filled, output);
  const std::lock_guard lock(mutex_);
  const auto known = timings_.find(key);
  if (known != timings_.end() && secondsSince(known->second.when) < kOld &&
      (!known->second.disturbed || runningJobs() > 0))
    return known->second;
  Timing timing = timed(input, filled, output, kFewVoxels);
  if (timing.times.total < kTooShort && voxelsOf(input.stacks) > 2 * kFewVoxels)
    timing = timed(input, filled, output, kMoreVoxels);
  if (known != timings_.end() &&
      known->second.times.total * timing.voxels < timing.times.total * known->second.voxels) {
    timing.times = known->second.times;
    timing.voxels = known->second.voxels;
    timing.outputVoxels = known->second.outputVoxels;
  }
  if (known == timings_.end() && timings_.size() >= 64) timings_.clear();
  return timings_[key] = timing;
}

/// Seconds for the prediction, its fit and a field that takes part in it.
double TimeEstimator::predictedSeconds(const ReconstructionInput& input, const Settings& settings,
                                       const Settings& filled, const GridGeometry& output) {
  ReconstructionInput thin = predictionOutline(input, output);
  Settings fitted = filled;
  fitted.prediction = PredictionKind::None;
  double seconds = this->seconds(thin, fitted);
  double predicting = multiplyTime_(settings.instructionSet) * kAlignedVoxel *
                      aligningVoxels(input.stacks, settings, voxelsOf(input.stacks)) /
                      threadCount(settings.threads);
  for (const Stack& scan : input.stacks) {
    const GridGeometry grid = candidateGrid(scan.image.geometry, thin.stacks.front().image.geometry);
    predicting += scanSeconds(scan, grid, settings);
    if (!triesField(settings, static_cast<double>(grid.voxelCount())) &&
        averagesWithField(scan, grid, settings))
      predicting += fieldSeconds(scan, grid, settings);
  }
  if (!DeviceChoice(settings.device, settings.instructionSet, settings.selection).onCpu() && seconds == 0)
    return 0;
  return seconds + predicting;
}

/// Seconds for a prediction from a scan's slices on a grid, with a field that takes part in it.
double TimeEstimator::scanSeconds(const Stack& scan, const GridGeometry& grid, const Settings& settings) {
  if (settings.prediction == PredictionKind::Interpolation) return 0;
  double seconds = learningSeconds(scan, grid, settings);
  if (!triesField(settings, static_cast<double>(grid.voxelCount()))) return seconds;
  return seconds + 1.35 * fieldSeconds(scan, grid, settings); // first on every second slice
}

/// Seconds for the volume, on a grid, of a field fitted to a scan's slices alone.
double TimeEstimator::fieldSeconds(const Stack& scan, const GridGeometry& grid, const Settings& settings) {
  ReconstructionInput slices;
  slices.stacks = {scan};
  slices.outputGrid = grid;
  return this->seconds(slices, fieldSettings(settings));
}

/// Seconds for predictions from each of several scans.
double TimeEstimator::eachSeconds(std::span<const Stack> stacks, const Settings& settings) {
  const GridGeometry domain = dataDomain(stacks);
  double seconds = 0;
  for (const Stack& scan : stacks)
    seconds += scanSeconds(scan, candidateGrid(scan.image.geometry, domain), scanSettings(settings));
  return seconds;
}

/// Seconds for choosing interpolations, learning from every second slice and from all, and mixing.
double TimeEstimator::learningSeconds(const Stack& scan, const GridGeometry& grid,
                                      const Settings& settings) const {
  const PredictionCost cost = predictionCost(scan, grid, settings);
  return multiplyTime_(settings.instructionSet) * (cost.choosing + cost.trial + cost.learning + cost.mixing);
}

double TimeEstimator::seconds(const ReconstructionInput& input, const Settings& settings) {
  if (!input.uncertainty || input.stacks.empty()) return fitSeconds(input, settings, true);
  const double fits = fitSeconds(input, settings, true);
  SimulatedFit simulated = simulatedOutline(input, settings);
  if (moves(input.stacks, settings)) { // as many fields and iterations as for what it simulates
    Settings filled = settings;
    makePlan(filled, withMovedSlices(geometryTraits(input.stacks)));
    simulated.settings.ensembleSize = filled.ensembleSize;
    simulated.settings.iterations = filled.iterations;
  }
  const double simulation = fitSeconds(simulated.input, simulated.settings, false);
  return fits > 0 && simulation > 0 ? fits + simulation : 0;
}

double TimeEstimator::fitSeconds(const ReconstructionInput& input, const Settings& settings, bool choosing) {
  checkSettings(settings);
  checkHeldOutFraction(input.heldOutFraction);
  if (input.stacks.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no image to reconstruct from: give at least one.");
  for (const Stack& stack : input.stacks)
    checkGeometry(stack.image.geometry, stack.name.empty() ? "The stack" : stack.name);
  const GridGeometry output = input.outputGrid ? *input.outputGrid : defaultOutputGrid(input.stacks);
  checkGeometry(output, "The output grid");
  DataTraits traits = geometryTraits(input.stacks);
  const bool moved = moves(input.stacks, settings);
  if (moved) traits = withMovedSlices(traits);
  if (!settings.iterations && traits.thickness == 0 && addsResidual(settings, traits) &&
      haveVoxels(input.stacks)) // the noise decides how many iterations there are
    traits.noise = noiseOf(input.stacks, chooseIntensityMap(input.stacks));
  // Share of the fitted voxels: Gaussians extend a few voxels, or a slice, beyond the mask.
  const double masked = maskedShare(input, traits.volume, std::max(traits.gap, 3 * traits.voxel));
  Settings filled = settings;
  const FitPlan plan = makePlan(filled, traits);
  const double voxels = masked * voxelsOf(input.stacks),
               outputVoxels = static_cast<double>(output.voxelCount());
  const double members = *filled.ensembleSize;
  const double heldOut = heldOutFraction(input);
  const double fits = heldOut > 0 ? 2 - heldOut : 1; // includes the fit that judges the quality
  if (predicts(settings, traits)) return fits * masked * predictedSeconds(input, settings, filled, output);
  double mixing = 0, trying = 0;
  if (predictsEach(settings, traits, input.stacks, !input.masks.empty())) {
    mixing = eachSeconds(input.stacks, settings);
    if (choosing) {
      const ShareTrial trial = shareTrialOutline(input.stacks, settings);
      if (!trial.refit.input.stacks.empty())
        trying = fitSeconds(trial.refit.input, trial.refit.settings, false);
    }
  }
  DeviceChoice device(settings.device, settings.instructionSet, settings.selection);
  device.considerSize(voxels * (plan.allAxes ? 3 : 1), *filled.ensembleSize * plan.iterations);
  if (!device.onCpu()) {
    const std::lock_guard lock(mutex_);
    const auto speed = speeds_.find(device.use.id);
    if (speed == speeds_.end()) return 0;
    return trying + fits * (mixing + speed->second.pass * voxels * members * plan.iterations / plan.subsets +
                            speed->second.rest * (voxels + outputVoxels));
  }
  const Timing timing = timingOf(input, filled, output);
  const TrialTimes& t = timing.times;
  const double iterations =
      plan.coarseIterations * t.coarse + (plan.iterations - plan.coarseIterations) * t.fine;
  const double refining = moved ? kMovedRefining : mixing > 0 ? 2 : 1; // times
  const double fit = members * (t.start + (moved ? kMovedFit : 1) * iterations) + refining * t.refine;
  const double placing = masked < 1 && input.stacks.size() > 1
                             ? kPlacing * multiplyTime_(settings.instructionSet) *
                                   static_cast<double>(dataDomain(input.stacks).voxelCount()) /
                                   threadCount(settings.threads)
                             : 0;
  return trying +
         fits * (mixing + placing + voxels / timing.voxels * fit +
                 plan.subsets * t.fine / timing.voxels * aligningVoxels(input.stacks, settings, voxels) +
                 outputVoxels / timing.outputVoxels * t.render);
}

void TimeEstimator::remember(const ReconstructionInput& input, const ReconstructionResult& result) {
  if (result.cancelled || result.device.id == "cpu" || result.iterationsRun < kFewIterations) return;
  const double voxels = voxelsOf(input.stacks),
               output = static_cast<double>(result.volume.geometry.voxelCount());
  if (voxels <= 0) return;
  Settings filled = result.settings;
  const double passes =
      static_cast<double>(result.iterationsRun) / makePlan(filled, geometryTraits(input.stacks)).subsets;
  const std::lock_guard lock(mutex_);
  speeds_[result.device.id] = {result.fitSeconds / (voxels * passes),
                               std::max(0.0, result.seconds - result.fitSeconds) / (voxels + output)};
}

double estimateSeconds(const ReconstructionInput& input, const Settings& settings) {
  return estimator().seconds(input, settings);
}

void rememberSpeed(const ReconstructionInput& input, const ReconstructionResult& result) {
  estimator().remember(input, result);
}

} // namespace innergs
