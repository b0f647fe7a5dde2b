#include "Core/Motion/DeformationFit.h"

#include "Core/Base/Random.h"
#include "Core/Motion/FrameLoss.h"

#include <algorithm>
#include <cmath>

namespace innergs {

DeformationFit::DeformationFit(const TimeSeries& series, const IntensityMap& map, DeformationPlan plan,
                               std::uint64_t seed, const KernelSet& kernels, ThreadPool& pool,
                               DeviceChoice* device)
    : series_(series), map_(map), plan_(std::move(plan)), seed_(seed), kernels_(kernels), pool_(pool),
      device_(device), voxel_(series.geometry.finestSpacing()), middle_(series.size() / 2) {
  field_ = emptyField(DynamicKind::Network, series, map, plan_.canonical.cutoff);
}

void DeformationFit::fitCanonical(const Report& report) {
  const GridGeometry covered =
      innergs::fitCanonical(field_.canonical, series_.frames[middle_], series_.geometry, map_,
                            plan_.canonical, seed_, kernels_, pool_, report, device_);
  field_.anchors.clear();
  for (const Gaussian& gaussian : field_.canonical.gaussians)
    field_.anchors.insert(field_.anchors.end(), gaussian.mean, gaussian.mean + 3);
  DeformationNetwork& network = field_.network;
  const auto [low, high] = boxInModel(covered, field_.canonical.modelToWorld);
  network.low = low;
  network.high = high;
  network.start = series_.times.front();
  network.end = series_.times.back();
  const int times = plan_.times > 0
                        ? plan_.times
                        : std::max(4, static_cast<int>(std::lround(static_cast<double>(series_.size()) /
                                                                   plan_.framesPerNode)));
  network.levels.clear();
  for (const double distance : plan_.nodeDistances) {
    DeformationNetwork::Level level;
    for (int a = 0; a < 3; ++a)
      level.size[a] =
          std::clamp(static_cast<int>(std::lround((high[a] - low[a]) / (distance * voxel_))) + 1, 2, 1024);
    level.times = std::min(times, 4096);
    network.levels.push_back(level);
  }
  const auto voxel = static_cast<float>(voxel_);
  network.scale = {voxel, voxel, voxel, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.1f, 0.02f, 0, 0, 0, 0};
  initialise(network, seed_);
}

void DeformationFit::startRefinement() {
  optimizer_.start(field_.canonical.size(), {AdamBlock(field_.network.parameters.size())});
}

void DeformationFit::resume(const DynamicField& field, const RefinementState& state) {
  field_ = field;
  startRefinement();
  optimizer_.resume(state);
}

void DeformationFit::refine(const Report& report) {
  if (optimizer_.step == 0) startRefinement();
  DeformationNetwork& network = field_.network;
  FrameLoss loss(observeFrames(series_, field_.canonical.modelToWorld, map_, pool_), kernels_, pool_,
                 device_);
  const std::size_t gaussians = field_.canonical.gaussians.size(), planes = network.planeParameters();
  DeformationEvaluator evaluator(network, field_.anchors, networkKernels(kernels_.name));
  GaussianField posed = field_.canonical;
  const FitPlan fit = fitPlan(plan_.canonical, voxel_);
  std::vector<float> change(16 * gaussians), gradient(16 * gaussians), back(network.parameters.size());
  Random random(seed_);
  const auto samples = static_cast<double>(loss.frame(middle_).samples);
  for (int s = 0; s < plan_.steps; ++s) {
    const double reach = std::max(1.0, static_cast<double>(series_.size()) * (s + 1) /
                                           std::max(1.0, plan_.growth * plan_.steps));
    const std::int64_t first = std::max<std::int64_t>(0, middle_ - static_cast<std::int64_t>(reach)),
                       last = std::min(series_.size() - 1, middle_ + static_cast<std::int64_t>(reach));
    const std::int64_t f =
        first + static_cast<std::int64_t>(random.next() % static_cast<std::uint64_t>(last - first + 1));
    if (s < optimizer_.step) continue; // done before the stop
    pool_.throwIfStopped();
    const double time = series_.times[f];
    evaluator.forward(network, time, change, pool_);
    addChanges(field_.canonical, change, posed, pool_);
    const double error = loss(posed, f, gradient);
    std::fill(back.begin(), back.end(), 0.f);
    evaluator.backward(network, time, gradient, back, pool_);
    addPlaneSmoothness(network, plan_.smoothInTime * samples / static_cast<double>(planes),
                       plan_.smoothInSpace * samples / static_cast<double>(planes), back);
    const double rate = std::pow(plan_.finalRate, static_cast<double>(s) / plan_.steps);
    const auto planeRate = static_cast<float>(rate * plan_.planeRate),
               weightRate = static_cast<float>(rate * plan_.weightRate);
    optimizer_.blocks.front().apply(
        network.parameters.data(), [&](std::int64_t i) { return back[i]; },
        [&](std::int64_t i) { return static_cast<std::size_t>(i) < planes ? planeRate : weightRate; }, pool_);
    optimizer_.canonical.apply(field_.canonical, gradient, fit.rates * (rate * plan_.canonicalRate),
                               fit.bounds, s + 1, pool_);
    optimizer_.add(error);
    if (s % 10 == 9) report(static_cast<double>(s + 1) / plan_.steps, optimizer_.mse);
  }
}

} // namespace innergs
