#include "Core/Motion/CanonicalFit.h"

#include "Core/Fit/Trainer.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr int kBatch = 8; // iterations that a device runs between reports

/// The frame with its margin, the edge voxels repeated outward; non-finite ones, too.
Volume padded(const std::vector<float>& frame, const GridGeometry& g,
              const std::array<std::int64_t, 3>& margin) {
  Volume out;
  out.geometry = g;
  for (int a = 0; a < 3; ++a)
    out.geometry.size[a] += 2 * margin[a];
  out.geometry.origin = g.indexToWorld()(
      {-static_cast<double>(margin[0]), -static_cast<double>(margin[1]), -static_cast<double>(margin[2])});
  const auto& n = out.geometry.size;
  out.voxels.reserve(static_cast<std::size_t>(out.geometry.voxelCount()));
  const auto inside = [&](std::int64_t x, int a) {
    return std::clamp<std::int64_t>(x - margin[a], 0, g.size[a] - 1);
  };
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i)
        out.voxels.push_back(frame[inside(i, 0) + g.size[0] * (inside(j, 1) + g.size[1] * inside(k, 2))]);
  return out;
}

} // namespace

FitPlan fitPlan(const CanonicalPlan& plan, double voxel) {
  FitPlan fit;
  fit.iterations = plan.iterations;
  fit.coarseIterations = std::min(8, plan.iterations / 2);
  fit.rates = {0.24 * voxel, 0.09, 0.09, 0.15, 0.03, 0};
  fit.cutoff = plan.cutoff;
  fit.bounds.minLogScale = std::log(0.3 * voxel);
  fit.bounds.maxLogScale = std::log(30 * voxel);
  fit.start.gaussians = plan.gaussians;
  return fit;
}

Observation observeFrame(const std::vector<float>& frame, const GridGeometry& geometry,
                         const Affine3& modelToWorld, const IntensityMap& map) {
  Stack stack;
  stack.image = {geometry, frame};
  stack.profile = SliceProfile::Point;
  std::vector<std::uint8_t> finite(frame.size());
  for (std::size_t v = 0; v < frame.size(); ++v) {
    finite[v] = std::isfinite(frame[v]);
    if (!finite[v]) stack.image.voxels[v] = static_cast<float>(map.offset);
  }
  Observation o = observe(stack, modelToWorld, map, false).front();
  const int stride = o.grid.stride(), nx = o.grid.nx;
  for (std::size_t v = 0; v < finite.size(); ++v)
    if (!finite[v]) {
      o.weight[v / nx * stride + v % nx] = 0;
      --o.samples;
    }
  return o;
}

std::vector<Observation> observeFrames(const TimeSeries& series, const Affine3& modelToWorld,
                                       const IntensityMap& map, const ThreadPool& pool) {
  std::vector<Observation> frames;
  for (const auto& frame : series.frames) {
    pool.throwIfStopped();
    frames.push_back(observeFrame(frame, series.geometry, modelToWorld, map));
  }
  return frames;
}

GridGeometry fitCanonical(GaussianField& field, const std::vector<float>& frame, const GridGeometry& g,
                          const IntensityMap& map, const CanonicalPlan& plan, std::uint64_t seed,
                          const KernelSet& kernels, ThreadPool& pool,
                          const std::function<void(double, double)>& report, DeviceChoice* device) {
  const double voxel = g.finestSpacing();
  std::array<std::int64_t, 3> margin;
  for (int a = 0; a < 3; ++a)
    margin[a] = std::max<std::int64_t>(1, std::llround(plan.margin * voxel / g.spacing[a]));
  const Volume volume = padded(frame, g, margin);
  // Placed as if voxels were cubes, then stretched: the slices of a dynamic scan are often thick.
  Stack cubes;
  cubes.image = volume;
  cubes.image.geometry.origin = {0, 0, 0};
  cubes.image.geometry.spacing = {1, 1, 1};
  cubes.image.geometry.direction = {};
  cubes.profile = SliceProfile::Point;
  GaussianField start = field;
  start.gaussians.clear();
  start.modelToWorld = {};
  const FitPlan fit = fitPlan(plan, voxel);
  initialise(start, makeProxy(std::span(&cubes, 1), start.modelToWorld, map, 1.0, pool), fit.start, seed,
             pool);
  start.modelToWorld = field.modelToWorld;
  const Affine3 toModel = inverse(field.modelToWorld) * volume.geometry.indexToWorld();
  for (Gaussian& gaussian : start.gaussians) {
    const Vec3 mean = toModel({gaussian.mean[0], gaussian.mean[1], gaussian.mean[2]});
    for (int a = 0; a < 3; ++a) {
      gaussian.mean[a] = static_cast<float>(mean[a]);
      gaussian.logScale[a] += static_cast<float>(std::log(g.spacing[a]));
    }
  }
  FitRequest request = fitRequest({observeFrame(volume.voxels, volume.geometry, field.modelToWorld, map)},
                                  fit, start, pool.stopToken());
  std::unique_ptr<FitDevice> placed = device ? device->makeFit(request) : nullptr;
  Trainer trainer(std::move(start), std::move(request), fit, kernels, pool, std::move(placed));
  while (trainer.step(kBatch)) {
    if (!trainer.failure().empty() && !device->onCpu())
      device->failed("before iteration " + std::to_string(trainer.iteration() + 1) +
                         " on the middle frame, and the fit continued",
                     trainer.failure());
    report(static_cast<double>(trainer.iteration()) / fit.iterations, trainer.mse());
  }
  field.gaussians = trainer.field().gaussians;
  return volume.geometry;
}

std::array<Vec3, 2> boxInModel(const GridGeometry& grid, const Affine3& modelToWorld) {
  const Affine3 indexToModel = inverse(modelToWorld) * grid.indexToWorld();
  Vec3 low = indexToModel({0, 0, 0}), high = low;
  const Vec3 other = indexToModel({grid.size[0] - 1.0, grid.size[1] - 1.0, grid.size[2] - 1.0});
  for (int a = 0; a < 3; ++a) {
    high[a] = std::max(low[a], other[a]);
    low[a] = std::min(low[a], other[a]);
  }
  return {low, high};
}

} // namespace innergs
