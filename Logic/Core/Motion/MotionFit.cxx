#include "Core/Motion/MotionFit.h"

#include "Core/Base/Random.h"
#include "Core/Motion/FrameFolds.h"
#include "Core/Motion/Pose.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace innergs {
MotionFit::MotionFit(const TimeSeries& series, const IntensityMap& map, MotionPlan plan, std::uint64_t seed,
                     const KernelSet& kernels, ThreadPool& pool, DeviceChoice* device)
    : series_(series), map_(map), plan_(plan), seed_(seed), kernels_(kernels), pool_(pool), device_(device),
      voxel_(series.geometry.finestSpacing()), middle_(series.size() / 2),
      field_(emptyField(DynamicKind::Motion, series, map, plan_.canonical.cutoff)),
      loss_(observeFrames(series, field_.canonical.modelToWorld, map, pool), kernels, pool, device) {}

void MotionFit::fitCanonical(const Report& report) {
  const GridGeometry covered =
      innergs::fitCanonical(field_.canonical, series_.frames[middle_], series_.geometry, map_,
                            plan_.canonical, seed_, kernels_, pool_, report, device_);
  field_.anchors.clear();
  for (const Gaussian& gaussian : field_.canonical.gaussians)
    field_.anchors.insert(field_.anchors.end(), gaussian.mean, gaussian.mean + 3);
  const auto [low, high] = boxInModel(covered, field_.canonical.modelToWorld);
  const double distance = plan_.nodeDistance * voxel_;
  field_.motionGrid = motionGridOver(low, high, {distance, distance, distance});
}

void MotionFit::track(const Report& report) {
  const std::int64_t count = series_.size();
  const std::size_t values = static_cast<std::size_t>(field_.motionGrid.nodes()) * MotionGrid::kValues;
  tracked_.assign(count, {});
  tracked_[middle_].nodes.assign(values, 0.f);
  Poser poser(field_);
  GaussianField posed = field_.canonical;
  std::vector<float> gradient(16 * posed.gaussians.size()), nodeGradient(values);
  const double bending = plan_.bending * static_cast<double>(loss_.frame(middle_).samples) /
                         static_cast<double>(field_.motionGrid.nodes());
  std::int64_t done = 0;
  const auto trackFrame = [&](std::int64_t f, std::int64_t before, std::int64_t beforeThat) {
    TrackedFrame& now = tracked_[f];
    now.nodes = tracked_[before].nodes;
    if (beforeThat >= 0 && beforeThat < count) {
      const double ratio = std::clamp((series_.times[f] - series_.times[before]) /
                                          (series_.times[before] - series_.times[beforeThat]),
                                      0.0, 2.0);
      for (std::size_t v = 0; v < values; ++v)
        now.nodes[v] += static_cast<float>(ratio) * (now.nodes[v] - tracked_[beforeThat].nodes[v]);
    }
    AdamBlock adam(values);
    for (int s = 0; s < plan_.trackingSteps; ++s) {
      pool_.throwIfStopped();
      poser.pose(field_, now.nodes, {}, posed, pool_);
      now.mse = loss_(posed, f, gradient);
      std::fill(nodeGradient.begin(), nodeGradient.end(), 0.f);
      poser.backward(field_, now.nodes, gradient, nodeGradient, pool_);
      addBending(field_.motionGrid, now.nodes, plan_.nodeDistance * voxel_, bending, nodeGradient);
      const double rate = std::pow(0.1, static_cast<double>(s) / plan_.trackingSteps);
      const auto shift = static_cast<float>(rate * plan_.trackingShift * voxel_),
                 turn = static_cast<float>(rate * plan_.trackingTurn);
      adam.apply(
          now.nodes.data(), [&](std::int64_t i) { return nodeGradient[i]; },
          [&](std::int64_t i) { return i % MotionGrid::kValues < 3 ? shift : turn; }, pool_);
    }
    report(static_cast<double>(++done) / static_cast<double>(std::max<std::int64_t>(1, count - 1)), now.mse);
  };
  for (std::int64_t f = middle_ + 1; f < count; ++f)
    trackFrame(f, f - 1, f - 2 >= middle_ ? f - 2 : -1);
  for (std::int64_t f = middle_ - 1; f >= 0; --f)
    trackFrame(f, f + 1, f + 2 < count ? f + 2 : -1);
}

double MotionFit::errorOf(std::span<const float> nodes, std::int64_t frame) {
  GaussianField posed = field_.canonical;
  Poser(field_).pose(field_, nodes, {}, posed, pool_);
  return loss_(posed, frame);
}

double MotionFit::predictionErrorBetween(std::int64_t f, bool cubic) {
  std::vector<std::int64_t> around{f - 1, f + 1};
  if (cubic && f >= 2) around.push_back(f - 2);
  if (cubic && f + 2 < series_.size()) around.push_back(f + 2);
  std::vector<float> nodes(tracked_[f].nodes.size(), 0.f);
  for (const std::int64_t a : around) {
    double weight = 1; // of Lagrange's interpolation
    for (const std::int64_t b : around)
      if (a != b) weight *= (series_.times[f] - series_.times[b]) / (series_.times[a] - series_.times[b]);
    for (std::size_t v = 0; v < nodes.size(); ++v)
      nodes[v] += static_cast<float>(weight) * tracked_[a].nodes[v];
  }
  return errorOf(nodes, f);
}

int MotionFit::chooseCoefficients() {
  const auto most = static_cast<int>(0.75 * static_cast<double>(series_.size()));
  int best = 4;
  double least = -1;
  for (const int coefficients : {4, 5, 6, 8, 10, 12, 14, 16, 18, 20, 24, 28, 32, 40, 48, 64, 96, 128}) {
    if (coefficients > most) break;
    const double error = predictionError(coefficients);
    if (least >= 0 && error >= least) continue;
    least = error;
    best = coefficients;
  }
  return best;
}

double MotionFit::predictionError(int coefficients) {
  const TimeSpline spline{series_.times.front(), series_.times.back(), coefficients};
  std::vector<float> nodes(static_cast<std::size_t>(field_.motionGrid.nodes()) * MotionGrid::kValues);
  double sum = 0;
  std::int64_t judged = 0;
  for (const FrameFold& fold : frameFolds(series_.times)) {
    const std::vector<double> rows = splinePrediction(spline, fold.keptTimes, fold.heldOutTimes, 0);
    for (std::size_t i = 0; i < fold.heldOut.size(); ++i, ++judged) {
      pool_.throwIfStopped();
      std::fill(nodes.begin(), nodes.end(), 0.f);
      for (std::size_t t = 0; t < fold.kept.size(); ++t) {
        const auto w = static_cast<float>(rows[i * fold.kept.size() + t]);
        for (std::size_t v = 0; v < nodes.size(); ++v)
          nodes[v] += w * tracked_[fold.kept[t]].nodes[v];
      }
      sum += errorOf(nodes, fold.heldOut[i]);
    }
  }
  return sum / static_cast<double>(std::max<std::int64_t>(1, judged));
}

void MotionFit::useSpline(int coefficients) {
  field_.motion = {series_.times.front(), series_.times.back(), coefficients};
  const std::vector<double> rows = splineFit(field_.motion, series_.times, 0);
  const std::size_t values = static_cast<std::size_t>(field_.motionGrid.nodes()) * MotionGrid::kValues;
  field_.nodes.assign(values * coefficients, 0.f);
  for (int k = 0; k < coefficients; ++k)
    for (std::size_t t = 0; t < tracked_.size(); ++t) {
      const auto w = static_cast<float>(rows[k * tracked_.size() + t]);
      for (std::size_t v = 0; v < values; ++v)
        field_.nodes[k * values + v] += w * tracked_[t].nodes[v];
    }
}

void MotionFit::startRefinement() {
  const std::size_t gaussians = field_.canonical.gaussians.size();
  const std::size_t values = static_cast<std::size_t>(field_.motionGrid.nodes()) * MotionGrid::kValues;
  // Of the grid's coefficients, then of the Gaussians' own.
  std::vector<AdamBlock> blocks(field_.motion.coefficients, AdamBlock(values));
  blocks.resize(blocks.size() + field_.own.coefficients, AdamBlock(3 * gaussians));
  optimizer_.start(static_cast<std::int64_t>(gaussians), std::move(blocks));
}

void MotionFit::resume(const DynamicField& field, const RefinementState& state) {
  field_ = field;
  startRefinement();
  optimizer_.resume(state);
}

void MotionFit::refine(const Report& report) {
  const std::size_t gaussians = field_.canonical.gaussians.size(), own = 3 * gaussians;
  const std::size_t values = static_cast<std::size_t>(field_.motionGrid.nodes()) * MotionGrid::kValues;
  if (optimizer_.step == 0) {
    field_.own = field_.motion;
    field_.ownPath.assign(own * field_.own.coefficients, 0.f);
    startRefinement();
  }
  AdamBlock *nodeAdam = optimizer_.blocks.data(), *ownAdam = nodeAdam + field_.motion.coefficients;
  const FitPlan fit = fitPlan(plan_.canonical, voxel_);
  Poser poser(field_);
  GaussianField posed = field_.canonical;
  std::vector<float> gradient(16 * gaussians), nodeGradient(values), move(own);
  std::vector<std::int64_t> order(series_.size());
  std::iota(order.begin(), order.end(), 0);
  Random random(seed_);
  const double bending = plan_.jointBending * static_cast<double>(loss_.frame(middle_).samples) /
                         static_cast<double>(field_.motionGrid.nodes());
  for (int s = 0; s < plan_.jointSteps; ++s) {
    const std::size_t turnOf = s % order.size();
    if (turnOf == 0)
      for (std::size_t n = order.size() - 1; n > 0; --n)
        std::swap(order[n], order[random.next() % (n + 1)]);
    if (s < optimizer_.step) continue; // done before the stop
    pool_.throwIfStopped();
    const std::int64_t f = order[turnOf];
    const double time = series_.times[f];
    const std::vector<float> nodes = nodesAt(field_, time);
    poser.pose(field_, nodes, time, posed, pool_);
    const double error = loss_(posed, f, gradient);
    std::fill(nodeGradient.begin(), nodeGradient.end(), 0.f);
    poser.backward(field_, nodes, gradient, nodeGradient, pool_);
    addBending(field_.motionGrid, nodes, plan_.nodeDistance * voxel_, bending, nodeGradient);
    const double rate = std::pow(plan_.finalRate, static_cast<double>(s) / plan_.jointSteps);
    const auto shift = static_cast<float>(rate * plan_.jointShift * voxel_),
               turn = static_cast<float>(rate * plan_.jointTurn);
    const TimeSpline::Weights w = field_.motion.at(time);
    for (int a = 0; a < w.count; ++a)
      nodeAdam[w.first + a].apply(
          field_.nodes.data() + (w.first + a) * values,
          [&](std::int64_t i) { return w.weight[a] * nodeGradient[i]; },
          [&](std::int64_t i) { return i % MotionGrid::kValues < 3 ? shift : turn; }, pool_);
    if (plan_.ownRate > 0) {
      const TimeSpline::Weights p = field_.own.at(time);
      const auto ownShift = static_cast<float>(rate * plan_.ownRate * voxel_),
                 penalty = static_cast<float>(plan_.ownPenalty);
      for (int a = 0; a < p.count; ++a) {
        float* path = field_.ownPath.data() + (p.first + a) * own;
        ownAdam[p.first + a].apply(
            path,
            [&](std::int64_t i) {
              return p.weight[a] * (gradient[16 * (i / 3) + i % 3] + penalty * path[i]);
            },
            [&](std::int64_t) { return ownShift; }, pool_);
      }
    }
    optimizer_.canonical.apply(field_.canonical, gradient, fit.rates * (rate * plan_.canonicalRate),
                               fit.bounds, s + 1, pool_);
    optimizer_.add(error);
    if (s % 10 == 9) report(static_cast<double>(s + 1) / plan_.jointSteps, optimizer_.mse);
  }
}

} // namespace innergs
