#include "Core/Job/ResidualRefinement.h"

#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Image/WienerFilter.h"
#include "Core/Prediction/PredictionNoise.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs {
namespace {

/// Adds a share of the mean of what a rendered field misses of predictions, without its noise.
void addPredicted(Volume& volume, const GaussianField& field, std::span<Stack> predictions, double share,
                  double noise, const RenderOptions& options, ThreadPool& pool) {
  std::vector<Volume> missed;
  std::vector<Affine3> maps; // from the volume's indices
  for (Stack& predicted : predictions) {
    Volume& rest = missed.emplace_back(render(field, predicted.image.geometry, options));
    for (std::size_t v = 0; v < rest.voxels.size(); ++v)
      rest.voxels[v] = predicted.image.voxels[v] - rest.voxels[v];
    removePredictionNoise(rest, predicted, noise, pool);
    maps.push_back(inverse(rest.geometry.indexToWorld()) * volume.geometry.indexToWorld());
  }
  const auto& n = volume.geometry.size;
  pool.run(n[1] * n[2], [&](std::int64_t row) {
    for (std::int64_t i = 0; i < n[0]; ++i) {
      const Vec3 at{static_cast<double>(i), static_cast<double>(row % n[1]), static_cast<double>(row / n[1])};
      float sum = 0, count = 0, value = 0;
      for (std::size_t m = 0; m < missed.size(); ++m) {
        if (!sampleInside(missed[m].geometry, missed[m].voxels.data(), maps[m](at), value)) continue;
        sum += value;
        ++count;
      }
      if (count > 0) volume.voxels[row * n[0] + i] += static_cast<float>(share) * sum / count;
    }
  });
}

Volume zeros(const GridGeometry& grid) {
  return {grid, std::vector<float>(static_cast<std::size_t>(grid.voxelCount()), 0.f)};
}

/// The scan's voxels, interpolated at those of a grid; 0 where it has none.
Volume spreadOver(const GridGeometry& grid, const Stack& scan, ThreadPool& pool) {
  Volume volume = zeros(grid);
  backProject(volume, {&scan, 1}, {.iterations = 1}, pool);
  return volume;
}

/// Takes noise out of differences between scans and a field as far as a Wiener filter takes it out of their
/// mean on the grid. noise: standard deviation of one scan's.
void removeNoise(std::span<Stack> missed, const GridGeometry& grid, double noise, ThreadPool& pool) {
  Volume kept = zeros(grid);  // the scans' sum, then the share of it to keep
  Volume scans = zeros(grid); // how many show a voxel
  for (const Stack& scan : missed) {
    Stack known = scan;
    for (float& v : known.image.voxels)
      v = std::isfinite(v) ? 1.f : v;
    const Volume part = spreadOver(grid, scan, pool), count = spreadOver(grid, known, pool);
    for (std::size_t v = 0; v < kept.voxels.size(); ++v) {
      kept.voxels[v] += part.voxels[v];
      scans.voxels[v] += count.voxels[v];
    }
  }
  const std::int64_t plane = grid.size[0] * grid.size[1];
  pool.run(grid.size[2], [&](std::int64_t k) {
    const std::span<float> values = std::span(kept.voxels).subspan(k * plane, plane);
    for (std::int64_t p = 0; p < plane; ++p) // to the noise of one scan; not finite where none shows it
      values[p] /= std::sqrt(scans.voxels[k * plane + p]);
    const std::vector<float> before(values.begin(), values.end());
    wienerFilter(values, grid.size[0], noise);
    for (std::int64_t p = 0; p < plane; ++p)
      values[p] = std::isfinite(before[p]) && before[p] != 0 ? values[p] / before[p] : 0;
  });
  for (Stack& scan : missed) {
    const std::vector<float> shares = projectToStack(kept, scan, pool);
    for (std::size_t v = 0; v < shares.size(); ++v)
      scan.image.voxels[v] *= shares[v];
  }
}

/// What a field misses of a scan, in its own units.
std::vector<float> missedOf(const GaussianField& field, const Stack& scan, const RenderOptions& options) {
  std::vector<float> missed = renderStack(field, scan, options).voxels;
  const auto scale = static_cast<float>(field.intensityScale);
  for (std::size_t v = 0; v < missed.size(); ++v)
    missed[v] = (scan.image.voxels[v] - missed[v]) / scale;
  return missed;
}

} // namespace

double refineToThinScans(GaussianField& field, std::span<const Stack> scans, double noise,
                         RenderOptions options, ThreadPool& pool) {
  options.bounded = false;
  std::vector<Stack> missed(scans.begin(), scans.end());
  for (Stack& scan : missed)
    scan.image.voxels = missedOf(field, scan, options);
  const GridGeometry grid = field.region();
  if (noise > 0) removeNoise(missed, grid, noise / field.intensityScale, pool);
  Volume residual = zeros(grid);
  backProject(residual, missed, {}, pool);
  if (std::any_of(residual.voxels.begin(), residual.voxels.end(), [](float x) { return x != 0; }))
    field.residual = std::move(residual);
  double squares = 0, count = 0;
  for (const Stack& scan : scans) {
    const std::vector<float> rest = missedOf(field, scan, options);
    for (std::size_t v = 0; v < rest.size(); ++v) {
      if (!std::isfinite(rest[v]) || (!scan.observed.empty() && !scan.observed[v])) continue;
      squares += static_cast<double>(rest[v]) * rest[v];
      ++count;
    }
  }
  return squares / std::max(1.0, count);
}

double refineToSlices(GaussianField& field, std::span<const Stack> slices, double noise,
                      const ValueRange& range, RenderOptions options, ThreadPool& pool,
                      std::span<Stack> predictions, double share) {
  options.bounded = false;
  Volume volume = render(field, field.region(), options);
  const std::vector<float> before = volume.voxels;
  if (share > 0) addPredicted(volume, field, predictions, share, noise, options, pool);
  BackProjectionPlan plan;
  plan.noise = noise;
  plan.range = range;
  const double rms = backProject(volume, slices, plan, pool);
  for (std::size_t v = 0; v < before.size(); ++v)
    volume.voxels[v] = static_cast<float>((volume.voxels[v] - before[v]) / field.intensityScale);
  if (std::any_of(volume.voxels.begin(), volume.voxels.end(), [](float x) { return x != 0; }))
    field.residual = std::move(volume);
  return rms * rms / (field.intensityScale * field.intensityScale);
}

double refineToPrediction(GaussianField& field, Stack& predicted, const std::optional<WeightedVolume>& other,
                          std::span<const Stack> scans, double noise, RenderOptions options,
                          ThreadPool& pool) {
  options.bounded = false;
  Volume missed = render(field, predicted.image.geometry, options);
  const auto scale = static_cast<float>(1 / field.intensityScale);
  for (std::size_t v = 0; v < missed.voxels.size(); ++v)
    missed.voxels[v] = predicted.image.voxels[v] - missed.voxels[v];
  removePredictionNoise(missed, predicted, noise, pool);
  for (std::size_t v = 0; other && v < missed.voxels.size(); ++v) {
    const float change =
        static_cast<float>(other->share) * (other->volume.voxels[v] - predicted.image.voxels[v]);
    missed.voxels[v] += change;
    predicted.image.voxels[v] += change;
  }
  for (float& v : missed.voxels)
    v = std::isfinite(v) ? scale * v : 0; // not finite where there is no prediction
  field.residual = std::move(missed);
  double squared = 0;
  std::int64_t count = 0;
  for (const Stack& scan : scans) {
    const std::vector<float> seen = projectToStack(predicted.image, scan, pool);
    for (std::size_t v = 0; v < seen.size(); ++v) {
      const double e = (static_cast<double>(seen[v]) - scan.image.voxels[v]) * scale;
      if (!std::isfinite(e)) continue;
      squared += e * e;
      ++count;
    }
  }
  return squared / static_cast<double>(std::max<std::int64_t>(1, count));
}

} // namespace innergs
