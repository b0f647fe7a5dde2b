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

PredictedScans predictSeveral(const PreparedInput& prepared, const Settings& settings,
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
  bool backProjects = true;
  for (std::size_t s = 0; s < prepared.stacks.size(); ++s) {
    const Stack& scan = prepared.stacks[s];
    const double to = from + (1 - from) * costs[s] / left;
    const PredictedPart part =
        predictPart(prepared, continued(prepared.stacks, s, kContinued, pool), grid, settings, parts,
                    {predicted.noise, share > 0}, fitField, {from, to}, progress, pool);
    joined.add(part.thin.image, scan, pool);
    if (fields) fields->add(part.field ? *part.field : part.thin.image, scan, pool);
    const std::string said = nameOf(scan, s) + ": " + part.sentence;
    predicted.sentence += (s > 0 ? " " : "") + said;
    progress.say(said);
    backProjects = backProjects && part.backProjects;
    left -= costs[s];
    from = to;
  }
  predicted.thin.image = joined.take();
  if (backProjects) {
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

PredictedPart predictPart(const PreparedInput& prepared, Stack scan, const GridGeometry& grid,
                          const Settings& settings, const PredictionParts& parts, const PartNoise& noise,
                          const SlicePrediction::FieldFit& fitField, const ProgressRange& range,
                          JobProgress& progress, ThreadPool& pool) {
  const auto at = [&](double fraction) { return range.from + (range.to - range.from) * fraction; };
  JobProgress own([&](const Progress& p) { progress.report(Phase::Predicting, at(p.fraction)); });
  PreparedInput one;
  one.stacks = {std::move(scan)};
  one.domain = prepared.domain;
  one.range = prepared.range;
  one.outputGrid = grid;
  SlicePrediction prediction(
      one, settings, parts, noise.deviation,
      [&](const Stack& slices, const GridGeometry& on, const Settings& alone, double begins, double ends) {
        return fitField(slices, on, alone, at(begins), at(ends));
      },
      false, own, pool);
  if (noise.keepsField) prediction.keepField();
  PredictedPart part;
  part.thin = prediction.predict();
  part.field = prediction.takeField();
  part.sentence = prediction.sentence();
  part.backProjects = prediction.backProjects();
  return part;
}

PredictedScans predictScans(const PreparedInput& prepared, const Settings& settings,
                            const PredictionParts& parts, const IntensityMap& map,
                            const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                            ThreadPool& pool) {
  const auto predict = prepared.stacks.size() == 1 ? predictOne : predictSeveral;
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
