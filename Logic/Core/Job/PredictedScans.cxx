#include "Core/Job/PredictedScans.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/Region.h"
#include "Core/Prediction/AdjoiningScans.h"
#include "Core/Prediction/CandidateGrid.h"
#include "Core/Prediction/PredictionNoise.h"

#include <algorithm>
#include <utility>

namespace innergs {
namespace {

constexpr int kContinued = 3; // slices of neighbours beyond each end of a scan

/// Of a scan, without what its slices share; as a share of the intensity range.
double noiseBetween(const Stack& scan, const IntensityMap& map) {
  return unpredictedNoise(scan, noiseOf({&scan, 1}, map));
}

void restrictTo(const Mask& support, PredictedScans& predicted, const std::stop_token& stop) {
  if (support.voxels.empty()) return;
  Stack& thin = predicted.thin;
  if (const auto block = blockOver(thin.image.geometry, boxOf(support.geometry))) {
    if (predicted.averaged) predicted.averaged->volume = cropped(predicted.averaged->volume, *block);
    const auto whole = static_cast<double>(thin.image.geometry.voxelCount());
    thin.image = cropped(thin.image, *block);
    predicted.kept = static_cast<double>(thin.image.geometry.voxelCount()) / whole;
  }
  thin.observed = resampleMask(support, thin.image.geometry, stop);
}

PredictedScans predictOne(const PreparedInput& prepared, const Settings& settings,
                          const PredictionParts& parts, const IntensityMap& map,
                          const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                          ThreadPool& pool) {
  const Stack& scan = prepared.stacks.front();
  const double noise = noiseBetween(scan, map),
               share = fieldShareOfNoisy(scan, settings, noise,
                                         predictedGrid(prepared.stacks, prepared.outputGrid).voxelCount());
  PredictedScans predicted;
  predicted.noise = noise * map.scale;
  SlicePrediction prediction(prepared, settings, parts, predicted.noise, fitField, true, progress, pool);
  if (share > 0) prediction.keepField();
  predicted.thin = prediction.predict();
  predicted.sentence = prediction.sentence();
  if (std::optional<Volume> field = prediction.takeField())
    predicted.averaged = WeightedVolume{std::move(*field), share};
  return predicted;
}

PredictedScans predictEach(const PreparedInput& prepared, const Settings& settings,
                           const PredictionParts& parts, const IntensityMap& map,
                           const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                           ThreadPool& pool) {
  const GridGeometry grid = predictedGrid(prepared.stacks, prepared.outputGrid);
  PredictedScans predicted;
  double noise = 0, share = 0;
  for (const Stack& scan : prepared.stacks) {
    const double own = noiseBetween(scan, map);
    noise = std::max(noise, own);
    share = std::max(share, fieldShareOfNoisy(scan, settings, own, grid.voxelCount()));
  }
  predicted.noise = noise * map.scale;
  std::vector<double> costs;
  double left = 0;
  for (const Stack& scan : prepared.stacks) {
    const GridGeometry own = candidateGrid(scan.image.geometry, grid);
    const PredictionCost cost = predictionCost(scan, own, settings);
    costs.push_back(cost.beforeFit(settings, static_cast<double>(own.voxelCount()), share > 0));
    left += costs.back() + cost.fit;
  }
  JoinedVolumes joined(grid);
  std::optional<JoinedVolumes> fields;
  if (share > 0) fields.emplace(grid);
  double from = progress.state.fraction;
  for (std::size_t s = 0; s < prepared.stacks.size(); ++s) {
    const Stack& scan = prepared.stacks[s];
    const double width = (1 - from) * costs[s] / left;
    const auto shareOf = [=](double fraction) { return from + width * fraction; };
    JobProgress part([&](const Progress& p) { progress.report(Phase::Predicting, shareOf(p.fraction)); });
    PreparedInput one;
    one.stacks = {continued(prepared.stacks, s, kContinued, pool)};
    one.domain = prepared.domain;
    one.range = prepared.range;
    one.outputGrid = grid;
    SlicePrediction prediction(
        one, settings, parts, predicted.noise,
        [&](const Stack& slices, const GridGeometry& on, const Settings& alone, double begins, double ends) {
          return fitField(slices, on, alone, shareOf(begins), shareOf(ends));
        },
        false, part, pool);
    if (share > 0) prediction.keepField();
    const Stack thin = prediction.predict();
    joined.add(thin.image, scan, pool);
    if (fields) {
      const std::optional<Volume> field = prediction.takeField();
      fields->add(field ? *field : thin.image, scan, pool);
    }
    const std::string name = nameOf(scan, s);
    predicted.sentence += (s > 0 ? " " : "") + name + ": " + prediction.sentence();
    progress.say(name + ": " + prediction.sentence());
    left -= costs[s];
    from += width;
  }
  predicted.thin.image = joined.take();
  if (settings.consistency) {
    BackProjectionPlan plan;
    plan.noise = predicted.noise;
    plan.range = prepared.range;
    backProject(predicted.thin.image, prepared.stacks, plan, pool);
  }
  predicted.thin.profile = SliceProfile::Point;
  predicted.thin.name = prepared.stacks.front().name;
  if (fields) predicted.averaged = WeightedVolume{fields->take(), share};
  return predicted;
}

} // namespace

PredictedScans predictScans(const PreparedInput& prepared, const Settings& settings,
                            const PredictionParts& parts, const IntensityMap& map,
                            const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                            ThreadPool& pool) {
  const auto predict = prepared.stacks.size() == 1 ? predictOne : predictEach;
  PredictedScans predicted = predict(prepared, settings, parts, map, fitField, progress, pool);
  restrictTo(prepared.support, predicted, pool.stopToken());
  if (predicted.averaged) {
    const std::string said =
        formatted("As the slices are noisy, %.0f %% of the result is a field fitted to them alone.",
                  100 * predicted.averaged->share);
    predicted.sentence += " " + said;
    progress.say(said);
  }
  return predicted;
}

} // namespace innergs
