#include "Core/Prediction/SlicePredictor.h"

#include "Core/Image/Metrics.h"
#include "Core/Image/Simulate.h"
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Prediction/CandidateWeights.h"
#include "Core/Prediction/SliceSampling.h"
#include "SpherePhantom.h"
#include "ThrownError.h"

#include <gtest/gtest.h>
#include <limits>
#include <numbers>

namespace innergs {
namespace {

using testing::spherePhantom;

constexpr int kGap = 3;

Stack smallStack(std::int64_t width = 48, std::int64_t depth = 37) {
  Volume truth = spherePhantom(width, depth);
  addNoise(truth.voxels, 1, 7);
  return keepEvery(truth, 2, kGap);
}

Prediction predict(const Stack& stack, const PredictionOptions& options, int threads = 2) {
  ThreadPool pool(threads);
  return predictAcrossSlices(stack, options, pool);
}

PredictionOptions with(PredictionEffort effort) {
  PredictionOptions options;
  options.effort = effort;
  return options;
}

/// The grid of the volume before only every gap-th slice was kept.
GridGeometry fineGrid(const Stack& kept, int gap) {
  GridGeometry grid = kept.image.geometry;
  grid.spacing[2] /= gap;
  grid.size[2] = (grid.size[2] - 1) * gap + 1;
  return grid;
}

/// dB over the slices that were not kept.
double between(const Volume& image, const Volume& truth, int gap) {
  std::vector<std::int64_t> slices;
  for (std::int64_t k = 0; k < truth.geometry.size[2]; ++k)
    if (k % gap) slices.push_back(k);
  return pooledQuality(image, truth, {}, 200, slices).psnr;
}

Volume sinc(const Stack& kept, int gap) {
  const auto& n = kept.image.geometry.size;
  const GridGeometry grid = fineGrid(kept, gap);
  return {grid, resampledAlong(kept.image.voxels.data(), 1, n[2], n[0] * n[1], {0, 1.0 / gap}, grid.size[2])};
}

TEST(SlicePredictor, BeatsInterpolationOnStructureItHasSeenAlongTheSlices) {
  Volume truth = spherePhantom(64, 61, 3);
  const Volume clean = truth;
  addNoise(truth.voxels, 1, 7);
  const Stack kept = keepEvery(truth, 2, 4);
  PredictionOptions options = with(PredictionEffort::Filter);
  options.grid = fineGrid(kept, 4);
  const Prediction filter = predict(kept, options);
  ASSERT_TRUE(filter.learned) << filter.sentence;
  options.effort = PredictionEffort::Fast;
  const Prediction network = predict(kept, options);
  ASSERT_TRUE(network.learned);
  const double bySinc = between(sinc(kept, 4), clean, 4), byFilter = between(filter.image, clean, 4),
               byNetwork = between(network.image, clean, 4);
  EXPECT_GT(byFilter, bySinc + 0.3);
  EXPECT_GT(byNetwork, byFilter + 0.5);
  EXPECT_LT(network.pairs.network, network.pairs.filter);
  EXPECT_LT(network.pairs.filter, network.pairs.cubic);
  EXPECT_EQ(network.phases, 4);
  for (std::size_t v = 0; v < 64 * 64; ++v) // the acquired slices are unchanged
    ASSERT_EQ(network.image.voxels[v], kept.image.voxels[v]);
}

TEST(SlicePredictor, IsBitIdenticalAtAnyNumberOfThreads) {
  const Stack stack = smallStack(32, 25);
  const Prediction one = predict(stack, with(PredictionEffort::Fast), 1);
  ASSERT_TRUE(one.learned) << one.sentence;
  for (const int threads : {2, 5}) {
    const Prediction other = predict(stack, with(PredictionEffort::Fast), threads);
    EXPECT_EQ(one.image.voxels, other.image.voxels) << threads;
    EXPECT_EQ(one.sentence, other.sentence);
  }
}

TEST(SlicePredictor, NeverLooksAtHeldOutVoxels) {
  Stack stack = smallStack();
  stack.observed.assign(stack.image.voxels.size(), 1);
  const auto& n = stack.image.geometry.size;
  for (std::int64_t p = 0; p < n[0] * n[1]; ++p)
    stack.observed[static_cast<std::size_t>(6 * n[0] * n[1] + p)] = 0; // a slice
  stack.observed[30 + 48 * (20 + 48 * 2)] = 0;
  Stack other = stack;
  float wrong = 1e5f;
  for (std::size_t v = 0; v < other.observed.size(); ++v)
    if (!other.observed[v]) other.image.voxels[v] = (wrong = -wrong);
  other.image.voxels[30 + 48 * (20 + 48 * 2)] = std::numeric_limits<float>::quiet_NaN();
  const Prediction a = predict(stack, with(PredictionEffort::Fast)),
                   b = predict(other, with(PredictionEffort::Fast));
  ASSERT_TRUE(a.learned) << a.sentence;
  EXPECT_EQ(a.image.voxels, b.image.voxels);
  EXPECT_EQ(a.predicted, b.predicted);
  ASSERT_FALSE(a.predicted.empty());
  const std::size_t area = 48 * 48;
  EXPECT_EQ(a.predicted[30 + 48 * 20 + area * (2 * kGap + 1)], 0); // interpolated next to it
  EXPECT_EQ(a.predicted[5 + 48 * 5 + area], 1);
  for (const float v : a.image.voxels)
    ASSERT_LT(std::abs(v), 1000);
}

TEST(SlicePredictor, MatchesLanczosOnABandLimitedVolume) {
  Volume truth; // white noise below 0.72 of what every second slice can resolve, identical along all axes
  truth.geometry.size = {64, 64, 49};
  truth.voxels.assign(64 * 64 * 49, 0.f);
  addNoise(truth.voxels, 200, 11);
  LineFilter low{-15, {}};
  for (int i = -15; i <= 15; ++i) {
    const double x = std::numbers::pi * i, window = 0.5 + 0.5 * std::cos(x / 16);
    low.weights.push_back(static_cast<float>(i == 0 ? 0.36 : window * std::sin(0.36 * x) / x));
  }
  for (const std::int64_t inner : {1, 64, 64 * 64}) {
    const std::vector<float> in = truth.voxels;
    const std::int64_t n = inner == 64 * 64 ? 49 : 64;
    for (std::int64_t v = 0; v < static_cast<std::int64_t>(in.size()); ++v) {
      double sum = 0;
      for (std::int64_t i = -15; i <= 15; ++i) {
        const std::int64_t at = v / inner % n, to = (at + i + n) % n;
        sum += low.weights[static_cast<std::size_t>(i + 15)] * in[v + (to - at) * inner];
      }
      truth.voxels[v] = static_cast<float>(sum);
    }
  }
  for (float& v : truth.voxels)
    v += 100;
  const Volume clean = truth;
  addNoise(truth.voxels, 0.5, 3);
  const Stack kept = keepEvery(truth, 2, 2);
  PredictionOptions options = with(PredictionEffort::Filter);
  options.grid = fineGrid(kept, 2);
  const Prediction prediction = predict(kept, options);
  ASSERT_TRUE(prediction.learned) << prediction.sentence;
  EXPECT_GT(between(prediction.image, clean, 2), between(sinc(kept, 2), clean, 2) - 0.1);
}

TEST(SlicePredictor, MatchingKeepsItSafeWhereTheScanIsSmoothAcross) {
  Volume truth = spherePhantom(64, 61, 5);
  const LineFilter blur = gaussianFilter(2);
  const Volume sharp = truth;
  const std::size_t area = 64 * 64;
  for (int k = 0; k < 61; ++k)
    for (std::size_t p = 0; p < area; ++p) {
      double sum = 0;
      for (std::size_t i = 0; i < blur.weights.size(); ++i)
        sum +=
            blur.weights[i] *
            sharp.voxels[static_cast<std::size_t>(std::clamp(k + blur.first + static_cast<int>(i), 0, 60)) *
                             area +
                         p];
      truth.voxels[static_cast<std::size_t>(k) * area + p] = static_cast<float>(sum);
    }
  const Volume clean = truth;
  addNoise(truth.voxels, 0.5, 3);
  const Stack kept = keepEvery(truth, 2, 2);
  PredictionOptions options = with(PredictionEffort::Filter);
  options.grid = fineGrid(kept, 2);
  ThreadPool pool(2);
  options.matchingBlur = chooseCandidates(kept, completeSlices(kept, pool), pool).blur;
  EXPECT_NEAR(options.matchingBlur, 2, 0.8);
  const Prediction matched = predict(kept, options);
  ASSERT_TRUE(matched.learned) << matched.sentence;
  options.matchingBlur = 0;
  const Prediction sharpened = predict(kept, options);
  const double byMatched = between(matched.image, clean, 2);
  EXPECT_GT(byMatched, between(sharpened.image, clean, 2) + 1);
  EXPECT_GT(byMatched, between(sinc(kept, 2), clean, 2) - 0.1);
}

TEST(SlicePredictor, GoesToTheGridAskedFor) {
  const Stack stack = smallStack();
  PredictionOptions options = with(PredictionEffort::Filter);
  const Prediction usual = predict(stack, options);
  EXPECT_EQ(usual.image.geometry, predictionGrid(stack.image.geometry));
  EXPECT_EQ(usual.image.geometry.size[2], 13 * kGap);
  GridGeometry grid = fineGrid(stack, kGap);
  grid.spacing[2] = 0.8; // not a whole number of samples per slice
  grid.size[2] = 40;
  options.grid = grid;
  const Prediction other = predict(stack, options);
  EXPECT_EQ(other.image.geometry, grid);
  options.grid = fineGrid(stack, kGap);
  const Prediction aligned = predict(stack, options);
  double difference = 0; // sample 15 of one is where sample 12 of the other is
  for (std::size_t v = 0; v < 48 * 48; ++v)
    difference += std::pow(other.image.voxels[15 * 48 * 48 + v] - aligned.image.voxels[12 * 48 * 48 + v], 2);
  EXPECT_LT(std::sqrt(difference / (48 * 48)), 3);
  grid.origin[0] += 0.3;
  options.grid = grid;
  EXPECT_THROW(predict(stack, options), Error);
}

TEST(SlicePredictor, TakesPixelsThatAreNotSquare) {
  Stack stack = smallStack();
  Stack wide = stack; // every second column
  wide.image.geometry.size[0] = 24;
  wide.image.geometry.spacing[0] = 2;
  wide.image.voxels.clear();
  for (std::size_t v = 0; v < stack.image.voxels.size(); v += 2)
    wide.image.voxels.push_back(stack.image.voxels[v]);
  const Prediction prediction = predict(wide, with(PredictionEffort::Filter));
  ASSERT_TRUE(prediction.learned) << prediction.sentence;
  EXPECT_EQ(prediction.image.geometry, predictionGrid(wide.image.geometry));
  EXPECT_EQ(prediction.image.voxels.size(), 24u * 48 * 13 * kGap);
}

TEST(SlicePredictor, ALargeNetworkIsUsedOnlyWhereItIsBetter) {
  const auto scan = [](double noise) {
    Volume truth = spherePhantom(32, 31);
    addNoise(truth.voxels, noise, 7);
    return keepEvery(truth, 2, kGap);
  };
  const Stack noisy = scan(20); // the large one learns the noise
  const PairErrors balanced = predict(noisy, with(PredictionEffort::Balanced)).pairs,
                   best = predict(noisy, with(PredictionEffort::Best)).pairs;
  ASSERT_GT(balanced.samples, 0);
  EXPECT_EQ(best.samples, balanced.samples);
  EXPECT_EQ(best.network, balanced.network);
  const Stack clean = scan(1);
  EXPECT_LT(predict(clean, with(PredictionEffort::Best)).pairs.network,
            predict(clean, with(PredictionEffort::Balanced)).pairs.network);
}

TEST(SlicePredictor, LearnsForLongerTheMoreThereIsToLearn) {
  GridGeometry scan;
  scan.size = {256, 256, 60};
  scan.spacing = {1, 1, 4};
  const auto learning = [&](PredictionEffort effort, double muchToLearn) {
    PredictionOptions options = with(effort);
    options.muchToLearn = muchToLearn;
    return predictionOperations(scan, options).learning;
  };
  const double usual = learning(PredictionEffort::Balanced, 0),
               most = learning(PredictionEffort::Balanced, 1);
  EXPECT_GT(most, 2 * usual);
  EXPECT_NEAR(learning(PredictionEffort::Balanced, 0.5), 0.5 * (usual + most), 1e-3 * usual);
  EXPECT_EQ(learning(PredictionEffort::Fast, 1), learning(PredictionEffort::Fast, 0));
}

TEST(SlicePredictor, SaysWhyNothingIsLearned) {
  const Stack stack = smallStack();
  const auto sentence = [](const Stack& s) {
    const Prediction prediction = predict(s, with(PredictionEffort::Filter));
    EXPECT_FALSE(prediction.learned);
    EXPECT_TRUE(prediction.image.voxels.empty());
    return prediction.sentence;
  };
  Stack close = stack;
  close.image.geometry.spacing[2] = 1.1;
  EXPECT_NE(sentence(close).find("as close as the pixels"), std::string::npos);
  Stack far = stack;
  far.image.geometry.spacing[2] = 13;
  EXPECT_NE(sentence(far).find("13 pixels apart"), std::string::npos);
  Stack few = stack;
  few.image.geometry.size[2] = 4;
  few.image.voxels.resize(4 * 48 * 48);
  EXPECT_NE(sentence(few).find("4 slices are too few"), std::string::npos);
  Stack constant = stack;
  std::fill(constant.image.voxels.begin(), constant.image.voxels.end(), 5.f);
  EXPECT_NE(sentence(constant).find("constant"), std::string::npos);
  Stack labels = stack;
  for (float& v : labels.image.voxels)
    v = v > 90;
  EXPECT_NE(sentence(labels).find("labels"), std::string::npos);
  Stack little = stack;
  little.image.geometry.size = {12, 48, 13};
  little.image.voxels.resize(12 * 48 * 13);
  EXPECT_NE(sentence(little).find("too few pixels"), std::string::npos);
}

TEST(SlicePredictor, LearnsFromEverySecondSliceWhateverTheScanCanLearn) {
  Volume truth = spherePhantom(72, 61);
  addNoise(truth.voxels, 1, 7);
  const Stack kept = keepEvery(truth, 2, 14); // every second of slices 7 pixels apart
  PredictionOptions options = with(PredictionEffort::Filter);
  EXPECT_NE(predict(kept, options).sentence.find("14 pixels apart"), std::string::npos);
  options.everySecond = true;
  const Prediction prediction = predict(kept, options);
  EXPECT_TRUE(prediction.learned) << prediction.sentence;
  Stack rounded = keepEvery(truth, 2, 12);
  rounded.image.geometry.spacing[2] *= 1 + 1e-7;
  EXPECT_TRUE(predict(rounded, with(PredictionEffort::Filter)).learned);
}

TEST(SlicePredictor, StopsInEveryPhaseAndItsProgressNeverFalls) {
  const Stack stack = smallStack(32, 25);
  for (const auto phase : {PredictionPhase::Matching, PredictionPhase::Learning, PredictionPhase::Applying}) {
    std::stop_source source;
    ThreadPool pool(2);
    pool.setStop(source.get_token());
    double last = 0;
    const auto stopInThePhase = [&](const PredictionProgress& p) {
      EXPECT_GE(p.fraction, last);
      last = p.fraction;
      if (p.phase == phase) source.request_stop();
    };
    EXPECT_EQ(
        test::codeOf([&] { predictAcrossSlices(stack, with(PredictionEffort::Fast), pool, stopInThePhase); }),
        ErrorCode::Cancelled)
        << predictionPhaseName(phase);
    EXPECT_LT(last, 1);
  }
}

} // namespace
} // namespace innergs
