#include "Core/Prediction/NetworkTraining.h"
#include "Core/Prediction/Orthogonal.h"
#include "Core/Prediction/StartWeights.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

// Columns at each side of a pair that are not scored: the pair ends there but the image continues.
constexpr int kSide = 4;
constexpr float kMomentum = 0.9f;

double rateAt(const TrainingPlan& plan, int step) {
  constexpr double rising = 0.05, falling = 0.475; // shares of the steps
  const double done = (step + 0.5) / plan.steps;
  return plan.rate * std::min({1.0, done / rising, (1 - done) / falling});
}

struct PairWork {
  Random random{0};
  TrainingPair pair;
  TrainingBatch batch;
  ConvolutionNetwork::Workspace network;
  std::vector<float> gradient;
  double loss = 0, counted = 0;
};

void batchOf(const TrainingPair& pair, int phases, float floor, TrainingBatch& batch) {
  makeFeatures(pair.low.data(), pair.slices, pair.columns, floor, batch.features);
  const int side = pair.columns > 4 * kSide ? kSide : 0;
  batch.thin.resize(static_cast<std::size_t>(batch.features.samples()) * phases);
  batch.counts.assign(static_cast<std::size_t>(batch.features.samples()), 0);
  for (int s = 0; s < pair.slices; ++s)
    for (int c = side; c < pair.columns - side; ++c) {
      const std::int64_t at = batch.features.at(s, c);
      const std::size_t v = static_cast<std::size_t>(s) * pair.columns + c;
      batch.counts[at] = pair.inside[v];
      std::copy_n(pair.thin.data() + v * phases, phases, batch.thin.data() + at * phases);
    }
}

} // namespace

double batchLoss(const ConvolutionNetwork& network, const PatchFilter& filter, const TrainingBatch& batch,
                 const ConvolutionNetwork::Transforms& transforms, const NetworkKernels& kernels,
                 ConvolutionNetwork::Workspace& work, std::vector<float>& gradient, double& counted) {
  const PatchFeatures& features = batch.features;
  const int outputs = outputStride(filter.phases);
  network.forward(features, transforms, kernels, work);
  std::vector<float> rest(work.outputs);
  applyFilter(filter, features, kernels, rest.data());
  double loss = 0;
  counted = 0;
  for (std::int64_t at = 0; at < features.samples(); ++at) {
    float* r = rest.data() + at * outputs;
    if (!batch.counts[at]) {
      std::fill_n(r, outputs, 0.f);
      continue;
    }
    const float scale = 1 / features.deviation[at];
    for (int q = 0; q < filter.phases; ++q) {
      r[q] -= (batch.thin[at * filter.phases + q] - features.mean[at]) * scale;
      loss += static_cast<double>(r[q]) * r[q];
      r[q] *= 2;
    }
    std::fill(r + filter.phases, r + outputs, 0.f);
    counted += filter.phases;
  }
  network.backward(features, rest, transforms, kernels, work, gradient);
  return loss;
}

ConvolutionNetwork trainNetwork(std::span<const TrainingSource> sources, const TrainingPlan& plan,
                                std::uint64_t seed, const NetworkKernels& kernels, ThreadPool& pool,
                                const std::function<void(double)>& progress) {
  const int phases = sources.front().sampling.phases;
  ConvolutionNetwork network({phases, plan.channels, plan.layers}, seed);
  if (!plan.fromScratch) setStartWeights(network, sources.front().sampling);
  const auto count = static_cast<std::int64_t>(network.parameters().size());
  std::vector<float> moment1(network.parameters().size(), 0.f), moment2 = moment1, sum = moment1;
  std::vector<PairWork> works(plan.pairs);
  const std::vector<ConvolutionNetwork::Matrix> matrices = network.matrices();
  constexpr double beta1 = 0.9, beta2 = 0.98;
  ConvolutionNetwork::Transforms transforms = network.transforms();
  for (int step = 0; step < plan.steps; ++step) {
    pool.run(plan.pairs, [&](std::int64_t p) {
      PairWork& work = works[p];
      work.random = randomOf(seed + 1, static_cast<std::int64_t>(step) * plan.pairs + p);
      const TrainingSource& from = sources.size() == 1
                                       ? sources.front()
                                       : sources[static_cast<std::size_t>(
                                             work.random.uniform() * static_cast<double>(sources.size()))];
      const PairPlace place = randomPlace(from.planes.learning, from.sampling, from.shape, work.random);
      makePair(from.planes.learning[place.plane], place, from.sampling, from.shape.slices, from.shape.columns,
               from.pairNoise, work.random, work.pair);
      batchOf(work.pair, phases, from.floor, work.batch);
      work.gradient.assign(static_cast<std::size_t>(count), 0.f);
      work.loss = batchLoss(network, from.filter, work.batch, transforms, kernels, work.network,
                            work.gradient, work.counted);
    });
    double counted = 0;
    for (const PairWork& work : works)
      counted += work.counted;
    if (!(counted > 0)) continue;
    const auto scale = static_cast<float>(1 / counted);
    const double correction1 = 1 - std::pow(beta1, step + 1), correction2 = 1 - std::pow(beta2, step + 1);
    const AdamScalars adam{static_cast<float>(rateAt(plan, step) / correction1), static_cast<float>(beta1),
                           static_cast<float>(beta2), static_cast<float>(1 / correction2)};
    pool.runToEnd(static_cast<std::int64_t>(matrices.size()), [&](std::int64_t m) {
      const ConvolutionNetwork::Matrix& matrix = matrices[m];
      const std::int64_t size = matrix.rows * matrix.columns, biases = matrix.columns;
      float* g = sum.data() + matrix.at;
      float* momentum = moment1.data() + matrix.at;
      float* parameters = network.parameters().data() + matrix.at;
      for (std::int64_t i = 0; i < size + biases; ++i) {
        g[i] = 0;
        for (const PairWork& work : works)
          g[i] += work.gradient[matrix.at + i];
        g[i] *= scale;
      }
      std::vector<float> direction(static_cast<std::size_t>(size));
      for (std::int64_t i = 0; i < size; ++i) {
        momentum[i] = kMomentum * momentum[i] + g[i];
        direction[i] = g[i] + kMomentum * momentum[i];
      }
      orthogonalise(direction, matrix.rows, matrix.columns, kernels);
      // Matches the size of Adam's steps.
      const auto rate = static_cast<float>(
          rateAt(plan, step) * 0.2 * std::sqrt(static_cast<double>(std::max(matrix.rows, matrix.columns))));
      for (std::int64_t i = 0; i < size; ++i)
        parameters[i] -= rate * direction[i];
      kernels.adam(adam, biases, g + size, momentum + size, moment2.data() + matrix.at + size,
                   parameters + size);
      network.transform(static_cast<std::size_t>(m), transforms);
    });
    pool.throwIfStopped();
    if (progress && step % 8 == 0) progress(static_cast<double>(step + 1) / plan.steps);
  }
  return network;
}

} // namespace innergs
