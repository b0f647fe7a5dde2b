#include "Core/Prediction/NetworkTraining.h"
#include "Core/Prediction/Orthogonal.h"
#include "Core/Prediction/StartWeights.h"

#include "Core/Image/Simulate.h"
#include "SpherePhantom.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

struct Example {
  ConvolutionNetwork network{{3, 16, 2}, 3};
  PatchFilter filter;
  TrainingBatch batch;

  Example() {
    Random random(5);
    const auto draw = [&] { return static_cast<float>(2 * random.uniform() - 1); };
    for (float& p : network.parameters())
      p += 0.1f * draw();
    constexpr int slices = 6, columns = 9;
    std::vector<float> low(slices * columns);
    for (float& v : low)
      v = draw();
    makeFeatures(low.data(), slices, columns, 0.1f, batch.features);
    batch.thin.resize(static_cast<std::size_t>(batch.features.samples()) * 3);
    for (float& v : batch.thin)
      v = draw();
    batch.counts.assign(static_cast<std::size_t>(batch.features.samples()), 0);
    for (int s = 0; s < slices; ++s)
      for (int c = 1; c < columns - 1; ++c)
        batch.counts[batch.features.at(s, c)] = 1;
    filter.phases = 3;
    filter.weights.assign(static_cast<std::size_t>(PatchFeatures::stride) * outputStride(3), 0.f);
    for (int i = 0; i < PatchFeatures::count; ++i)
      for (int q = 0; q < 3; ++q)
        filter.weights[static_cast<std::size_t>(i) * outputStride(3) + q] = 0.1f * draw();
  }

  double loss(std::vector<float>& gradient, const char* set = "scalar") {
    gradient.assign(network.parameters().size(), 0.f);
    ConvolutionNetwork::Workspace work;
    double counted = 0;
    const double sum =
        batchLoss(network, filter, batch, network.transforms(), networkKernels(set), work, gradient, counted);
    EXPECT_EQ(counted, 6 * 7 * 3);
    return sum;
  }
};

TEST(Network, GradientsAgreeWithFiniteDifferences) {
  Example example;
  std::vector<float> gradient, unused;
  example.loss(gradient);
  auto& parameters = example.network.parameters();
  Random random(9);
  int outside = 0;
  double largest = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const std::size_t i = random.next() % parameters.size();
    const float before = parameters[i], h = 2e-3f;
    parameters[i] = before + h;
    const double above = example.loss(unused);
    parameters[i] = before - h;
    const double below = example.loss(unused);
    parameters[i] = before;
    const double difference = (above - below) / (2 * h);
    largest = std::max(largest, std::abs(difference));
    outside += std::abs(difference - gradient[i]) > 0.02 * (1 + std::abs(difference));
  }
  EXPECT_GT(largest, 1);
  EXPECT_LE(outside, 6); // where a rectifier's kink lies between the two points
}

TEST(Network, InstructionSetsAgreeInLossAndGradient) {
  Example example;
  std::vector<float> reference, gradient;
  const double expected = example.loss(reference);
  for (const NetworkKernels& set : networkKernelSets()) {
    EXPECT_NEAR(example.loss(gradient, set.name.c_str()), expected, 1e-4 * expected) << set.name;
    for (std::size_t i = 0; i < gradient.size(); ++i)
      ASSERT_NEAR(gradient[i], reference[i], 1e-3) << set.name << " " << i;
  }
}

TEST(Network, ComputesPartsOfAnImageAsInTheWhole) {
  const Example example;
  constexpr int slices = 16, columns = 30;
  std::vector<float> low(slices * columns);
  Random random(6);
  for (float& v : low)
    v = static_cast<float>(random.uniform());
  const ConvolutionNetwork& network = example.network;
  const int reach = network.reach(), outputs = outputStride(network.shape().phases);
  std::vector<ColumnSpan> spans(slices);
  for (int s = 8 - reach; s <= 8 + reach; ++s)
    spans[s] = {12 - reach, 13 + reach};
  PatchFeatures whole, part;
  makeFeatures(low.data(), slices, columns, 0.1f, whole);
  makeFeatures(low.data(), slices, columns, 0.1f, part, 0, 0, spans);
  ConvolutionNetwork::Workspace work, partWork;
  for (const NetworkKernels& set : networkKernelSets()) {
    network.forward(whole, network.transforms(), set, work);
    network.forward(part, network.transforms(), set, partWork);
    std::vector<float> filtered(work.outputs.size(), 0.f), partFiltered = filtered;
    applyFilter(example.filter, whole, set, filtered.data());
    applyFilter(example.filter, part, set, partFiltered.data());
    const std::int64_t at = whole.at(8, 12) * outputs;
    for (int q = 0; q < network.shape().phases; ++q) {
      EXPECT_NEAR(partWork.outputs[at + q], work.outputs[at + q], 1e-5) << set.name;
      EXPECT_EQ(partFiltered[at + q], filtered[at + q]) << set.name;
    }
  }
}

TEST(Network, OrthogonalisedColumnsAreNearlyOrthonormal) {
  constexpr std::int64_t rows = 40, columns = 16;
  std::vector<float> values(rows * columns);
  Random random(2);
  for (float& v : values)
    v = static_cast<float>(2 * random.uniform() - 1);
  orthogonalise(values, rows, columns, networkKernels("scalar"));
  for (std::int64_t a = 0; a < columns; ++a)
    for (std::int64_t b = 0; b < columns; ++b) {
      double product = 0;
      for (std::int64_t r = 0; r < rows; ++r)
        product += static_cast<double>(values[r * columns + a]) * values[r * columns + b];
      EXPECT_NEAR(product, a == b, a == b ? 0.6 : 0.35);
    }
}

SliceSampling samplingOf(int phases, SliceProfile profile) {
  Stack stack;
  stack.image.geometry.size = {8, 8, 8};
  stack.image.geometry.spacing = {1, 1, static_cast<double>(phases)};
  stack.thickness = phases;
  stack.profile = profile;
  GridGeometry thin = stack.image.geometry;
  thin.spacing[2] = 1;
  return sliceSampling(stack, thin, phases);
}

TEST(StartWeights, FitTheNetworksThatAreTrained) {
  for (const int channels : {16, 32, 64})
    for (const int phases : {2, 5, 20})
      for (const SliceProfile profile : {SliceProfile::Point, SliceProfile::Box}) {
        ConvolutionNetwork network({phases, channels, 4}, 1);
        setStartWeights(network, samplingOf(phases, profile));
        const ConvolutionNetwork::Matrix last = network.matrices().back();
        for (std::int64_t row = 0; row <= last.rows; ++row)
          for (int q = phases; q < last.columns; ++q)
            ASSERT_EQ(network.parameters()[last.at + row * last.columns + q], 0);
        double squares = 0;
        for (const float weight : network.parameters()) {
          ASSERT_TRUE(std::isfinite(weight));
          squares += static_cast<double>(weight) * weight;
        }
        EXPECT_GT(squares, 1);
      }
  const auto startOf = [](int channels, int layers, SliceProfile profile) {
    ConvolutionNetwork network({4, channels, layers}, 1);
    setStartWeights(network, samplingOf(4, profile));
    return network.parameters();
  };
  EXPECT_EQ(startOf(16, 3, SliceProfile::Point), ConvolutionNetwork({4, 16, 3}, 1).parameters());
  EXPECT_NE(startOf(16, 4, SliceProfile::Point), startOf(16, 4, SliceProfile::Box));
}

TEST(StartWeights, GiveWiderNetworksTheSameOutputs) {
  const NetworkKernels& kernels = networkKernels("");
  constexpr int slices = 7, columns = 9, phases = 4;
  std::vector<float> values(slices * columns);
  Random random(3);
  for (float& v : values)
    v = static_cast<float>(100 * random.uniform());
  PatchFeatures features;
  makeFeatures(values.data(), slices, columns, 1, features);
  const auto outputsOf = [&](int channels) {
    ConvolutionNetwork network({phases, channels, 4}, 1);
    setStartWeights(network, samplingOf(phases, SliceProfile::Point));
    ConvolutionNetwork::Workspace work;
    network.forward(features, network.transforms(), kernels, work);
    return work.outputs;
  };
  const std::vector<float> learned = outputsOf(32), wider = outputsOf(64);
  const auto [least, most] = std::minmax_element(learned.begin(), learned.end());
  EXPECT_GT(*most - *least, 0.1);
  ASSERT_EQ(wider.size(), learned.size());
  for (std::size_t i = 0; i < learned.size(); ++i)
    ASSERT_NEAR(wider[i], learned[i], 1e-5) << i;
}

TEST(StartWeights, LearnFasterThanWeightsDrawnAtRandom) {
  ThreadPool pool(2);
  constexpr int phases = 4;
  Stack stack;
  stack.image = testing::spherePhantom(96, 24);
  addNoise(stack.image.voxels, 1, 7);
  stack.thickness = 1;
  stack.image.geometry.spacing[2] = phases;
  GridGeometry thin = stack.image.geometry;
  thin.spacing[2] = 1;
  const SliceSampling sampling = sliceSampling(stack, thin, phases);
  const FilledImage filled = filledImage(stack);
  const TrainingPlanes planes = trainingPlanes(filled, knownBody(filled, {}), sampling, {}, pool);
  TrainingPlan plan;
  plan.channels = 16;
  plan.steps = 60;
  const PairShape shape = pairShape(planes, sampling, 24, plan.most);
  const NetworkKernels& kernels = networkKernels("");
  const PatchFilter filter = learnFilter(planes, sampling, shape, 0, 1, kernels, pool);
  const TrainingSource source{planes, sampling, filter, shape, 1};
  const auto errorOf = [&](bool fromScratch) {
    plan.fromScratch = fromScratch;
    const ConvolutionNetwork network = trainNetwork({&source, 1}, plan, 1, kernels, pool, {});
    double loss = 0;
    for (int p = 0; p < 20; ++p) {
      Random random = randomOf(99, p);
      TrainingPair pair;
      const PairPlace place = randomPlace(planes.measuring, sampling, shape, random);
      makePair(planes.measuring[place.plane], place, sampling, shape.slices, shape.columns, 0, random, pair);
      TrainingBatch batch;
      makeFeatures(pair.low.data(), pair.slices, pair.columns, source.floor, batch.features);
      batch.thin.resize(static_cast<std::size_t>(batch.features.samples()) * phases);
      batch.counts.assign(static_cast<std::size_t>(batch.features.samples()), 0);
      for (int s = 0; s < pair.slices; ++s)
        for (int c = 0; c < pair.columns; ++c) {
          const std::int64_t at = batch.features.at(s, c);
          batch.counts[at] = pair.inside[static_cast<std::size_t>(s) * pair.columns + c];
          std::copy_n(pair.thin.data() + (static_cast<std::size_t>(s) * pair.columns + c) * phases, phases,
                      batch.thin.data() + at * phases);
        }
      ConvolutionNetwork::Workspace work;
      std::vector<float> gradient(network.parameters().size(), 0.f);
      double counted = 0;
      loss += batchLoss(network, filter, batch, network.transforms(), kernels, work, gradient, counted);
    }
    return loss;
  };
  EXPECT_LT(errorOf(false), 0.98 * errorOf(true));
}

} // namespace
} // namespace innergs
