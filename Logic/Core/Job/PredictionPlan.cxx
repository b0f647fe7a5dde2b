#include "Core/Job/PredictionPlan.h"

#include "Core/Base/Parallel.h"
#include "Core/Fit/Plan.h"
#include "Core/Prediction/CandidateGrid.h"

#include <algorithm>

namespace innergs {
namespace {

constexpr int kLongerFit = 60;       // iterations of the field
constexpr int kTrialFit = 20;        // likewise on every second slice of a large scan, where more overfit
constexpr double kLarge = 1.5e6;     // voxels
constexpr double kMostFitted = 10e6; // voxels of a field that takes longer than all else
// A field's share in the average with a noisy prediction rises from 0 at the first of these noises, relative
// to the intensity range, to that of thin or of touching thick slices at the second; less than the least is
// not worth a fit.
constexpr double kLittleNoise = 0.01, kMuchNoise = 0.02;
constexpr double kThinShare = 0.3, kThickShare = 0.6, kLeastFieldShare = 0.05;
// In multiply-adds, as PredictionCost.
constexpr double kChoosing = 2e10, kChoosingVoxel = 1e4; // once, and per voxel of the scan
constexpr double kMixing = 2e3, kBackProjecting = 2e3;   // per voxel of the prediction
constexpr double kIteration = 1e3, kThickIteration = 25e3, kFinishing = 15e3; // of a fit, per voxel

/// A scan without its voxels.
Stack outlineOf(const Stack& scan, const GridGeometry& geometry) {
  Stack outline;
  outline.image.geometry = geometry;
  outline.thickness = scan.thickness;
  outline.profile = scan.profile;
  return outline;
}

/// Of a fit to a scan's slices, with its volume on a grid.
double fitCost(const Stack& scan, const GridGeometry& grid, Settings settings) {
  const DataTraits traits = geometryTraits({&scan, 1});
  const int iterations = makePlan(settings, traits).iterations;
  const double each = traits.superResolution() ? kThickIteration : kIteration;
  return (each * iterations * *settings.ensembleSize * static_cast<double>(scan.image.geometry.voxelCount()) +
          kFinishing * static_cast<double>(grid.voxelCount())) /
         threadCount(settings.threads);
}

} // namespace

bool triesField(const Settings& settings, double voxels) {
  return voxels <= (settings.preset == Preset::Best ? kMostFitted : kLarge);
}

TrialGrids trialGrids(const GridGeometry& scan) {
  TrialGrids grids{scan, scan};
  grids.kept.size[2] = (scan.size[2] + 1) / 2;
  grids.kept.spacing[2] *= 2;
  grids.all.size[2] = 2 * grids.kept.size[2] - 1;
  return grids;
}

PredictionEffort learningEffort(const Settings& settings, double voxels, bool trial) {
  if (trial || settings.preset == Preset::Fast)
    return voxels > kLarge ? PredictionEffort::Brief : PredictionEffort::Fast;
  return settings.preset == Preset::Best ? PredictionEffort::Best : PredictionEffort::Balanced;
}

Settings fieldSettings(const Settings& settings, bool longer, bool noisy) {
  Settings field;
  field.preset = settings.preset == Preset::Best && !noisy ? Preset::Balanced : Preset::Fast;
  field.prediction = PredictionKind::None;
  if (settings.preset == Preset::Balanced && longer) field.iterations = kLongerFit;
  field.ensembleSize = 1;
  field.consistency = settings.consistency;
  field.threads = settings.threads;
  field.instructionSet = settings.instructionSet;
  field.device = settings.device;
  field.seed = settings.seed;
  return field;
}

double relativeThickness(const Stack& scan) {
  if (scan.profile == SliceProfile::Point) return 0;
  return std::min(1.0, effectiveThickness(scan) / scan.image.geometry.spacing[2]);
}

double fieldShareOfNoisy(const Stack& scan, const Settings& settings, double noise, std::int64_t voxels) {
  if (settings.prediction == PredictionKind::Interpolation || static_cast<double>(voxels) > kMostFitted)
    return 0;
  const double share = std::clamp((noise - kLittleNoise) / (kMuchNoise - kLittleNoise), 0.0, 1.0) *
                       (kThinShare + relativeThickness(scan) * (kThickShare - kThinShare));
  return share < kLeastFieldShare ? 0 : share;
}

ReconstructionInput predictionOutline(const ReconstructionInput& input, const GridGeometry& output) {
  ReconstructionInput thin;
  Stack& stack = thin.stacks.emplace_back();
  stack.image.geometry = predictedGrid(input.stacks, output);
  stack.profile = SliceProfile::Point;
  thin.outputGrid = output;
  return thin;
}

Settings trialFieldSettings(const Settings& settings, double voxels, bool noisy) {
  Settings field = fieldSettings(settings, false, noisy);
  if (voxels > kLarge) {
    field.iterations = kTrialFit;
    field.consistency = false; // being anchored to the slices does much the same
  }
  return field;
}

Settings scanSettings(Settings settings) {
  settings.preset = Preset::Fast;
  return settings;
}

double learningCost(const GridGeometry& scan, const GridGeometry& grid, PredictionEffort effort,
                    const Settings& settings, double muchToLearn) {
  PredictionOptions options;
  options.effort = effort;
  options.muchToLearn = muchToLearn;
  options.grid = grid;
  const PredictionOperations each =
      predictionOperations(scan, options).perThread(threadCount(settings.threads));
  return each.learning + each.applying;
}

double PredictionCost::beforeFit(const Settings& settings, double voxels, bool averaged) const {
  const bool tries = triesField(settings, voxels);
  return choosing + mixing + trial + learning + (tries ? trialField : 0) + (tries || averaged ? field : 0);
}

PredictionCost predictionCost(const Stack& scan, const GridGeometry& grid, const Settings& settings) {
  const GridGeometry& g = scan.image.geometry;
  const auto voxels = static_cast<double>(grid.voxelCount());
  const double threads = threadCount(settings.threads);
  const Stack outline = outlineOf(scan, g);
  PredictionCost cost;
  cost.choosing = (kChoosing + kChoosingVoxel * static_cast<double>(g.voxelCount())) / threads;
  cost.mixing =
      (scan.profile == SliceProfile::Point ? kMixing : kMixing + kBackProjecting) * voxels / threads;
  if (settings.prediction != PredictionKind::Interpolation) {
    const TrialGrids half = trialGrids(g);
    const Stack kept = outlineOf(scan, half.kept);
    const Settings field = fieldSettings(settings);
    cost.trial = learningCost(half.kept, half.all, learningEffort(settings, voxels, true), settings);
    cost.learning = learningCost(g, grid, learningEffort(settings, voxels, false), settings);
    if (triesField(settings, voxels))
      cost.trialField = fitCost(kept, half.all, trialFieldSettings(settings, voxels));
    cost.field = fitCost(outline, grid, field);
  }
  Settings fitted = settings;
  makePlan(fitted, geometryTraits({&outline, 1})); // with the prediction
  fitted.prediction = PredictionKind::None;
  Stack thin = outlineOf(scan, grid);
  thin.profile = SliceProfile::Point;
  cost.fit = fitCost(thin, grid, fitted);
  return cost;
}

} // namespace innergs
