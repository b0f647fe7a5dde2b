#include "Core/Job/PredictionPlan.h"
#include "Core/Prediction/CandidateGrid.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/RenderPoints.h"
#include "JobInputs.h"

#include <algorithm>
#include <cmath>

namespace innergs::testing {
namespace {

/// A scan with slices four pixels apart, with some structure to learn from.
ReconstructionInput gappedInput(std::int64_t size = 48) {
  const GridGeometry filled = grid(size, size - 4, 45, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));
  return inputOf({keepEvery(phantom(filled), 2, 4)});
}

Settings quick(PredictionKind kind = PredictionKind::Auto) {
  Settings settings = fastSettings();
  settings.prediction = kind;
  return settings;
}

TEST(JobPrediction, IsNotBelowInterpolationAndSaysWhatItIs) {
  const ReconstructionInput input = gappedInput();
  ReconstructionInput same = input;
  const Volume truth = phantom(grid(48, 44, 45, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3)));
  same.outputGrid = truth.geometry;
  const auto field = reconstruct(same, quick(PredictionKind::None));
  const auto interpolated = reconstruct(same, quick(PredictionKind::Interpolation));
  const auto chosen = reconstruct(same, quick());
  EXPECT_TRUE(field.prediction.empty());
  EXPECT_NE(interpolated.prediction.find("interpolation"), std::string::npos);
  EXPECT_FALSE(chosen.prediction.empty());
  EXPECT_GE(psnr(chosen.volume, truth), psnr(interpolated.volume, truth) - 0.02);
}

TEST(JobPrediction, LeavesNoiseOut) {
  const Volume truth = phantom(grid(48, 44, 45, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3)));
  const Volume slices = keepEvery(truth, 2, 4).image;
  const auto rmsOfSlices = [&](double noise) {
    ReconstructionInput input = gappedInput();
    input.outputGrid = slices.geometry;
    addNoise(input.stacks.front().image.voxels, noise, 2);
    const Volume result = reconstruct(input, quick()).volume;
    double squares = 0;
    for (std::size_t v = 0; v < result.voxels.size(); ++v)
      squares += std::pow(static_cast<double>(result.voxels[v]) - slices.voxels[v], 2);
    return std::sqrt(squares / static_cast<double>(result.voxels.size()));
  };
  const auto [low, high] = std::minmax_element(truth.voxels.begin(), truth.voxels.end());
  const double range = static_cast<double>(*high) - *low;
  EXPECT_LT(rmsOfSlices(0), 1e-3 * range);
  EXPECT_LT(rmsOfSlices(0.05 * range), 0.75 * 0.05 * range);
}

/// A scan of touching slices four pixels thick with 5 % noise, on the grid of its truth.
ReconstructionInput noisyInput(const Volume& truth) {
  ReconstructionInput input = inputOf({simulateThickStack(truth, 2, 4)});
  input.outputGrid = truth.geometry;
  const auto [low, high] = std::minmax_element(truth.voxels.begin(), truth.voxels.end());
  addNoise(input.stacks.front().image.voxels, 0.05 * (*high - *low), 2);
  return input;
}

TEST(JobPrediction, OfNoisySlicesIsAveragedWithAField) {
  const Volume truth = phantom(grid(48, 44, 48, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3)));
  const ReconstructionInput input = noisyInput(truth);
  const auto averaged = reconstruct(input, quick());
  ReconstructionInput parts = input;
  parts.predictionParts.field = false;
  const auto learned = reconstruct(parts, quick());
  const std::string said = "of the result is a field";
  EXPECT_NE(averaged.prediction.find(said), std::string::npos) << averaged.prediction;
  EXPECT_EQ(learned.prediction.find(said), std::string::npos);
  EXPECT_EQ(reconstruct(gappedInput(), quick()).prediction.find(said), std::string::npos);
  EXPECT_GT(psnr(averaged.volume, truth), psnr(learned.volume, truth) + 0.1);
}

TEST(JobPrediction, OfNoisySlicesStopsAndGoesOn) {
  const ReconstructionInput input = noisyInput(phantom(grid(24, 24, 40)));
  Settings settings = quick();
  const auto whole = reconstruct(input, settings);
  ASSERT_NE(whole.prediction.find("of the result is a field"), std::string::npos) << whole.prediction;
  const auto stopped =
      runUntil([](const Progress& p) { return p.phase == Phase::Predicting && p.fraction > 0.35; }, input,
               settings)
          .result;
  ASSERT_TRUE(stopped.cancelled);
  EXPECT_TRUE(stopped.model->field.gaussians.empty());
  ReconstructionInput again = input;
  again.resume = stoppedAt(5, input, settings).model;
  settings.threads = 5;
  EXPECT_TRUE(sameField(reconstruct(again, settings).model->field, whole.model->field));
}

TEST(JobPrediction, KeepsTextureThatAllSlicesShow) {
  const Volume slice = texture(grid(48, 44, 1));
  const Volume truth =
      volumeOf(grid(48, 44, 33), [&](auto i, auto j, auto) { return slice.voxels[i + 48 * j]; });
  ReconstructionInput input = inputOf({keepEvery(truth, 2, 4)});
  input.outputGrid = truth.geometry;
  const auto [low, high] = std::minmax_element(truth.voxels.begin(), truth.voxels.end());
  EXPECT_GT(psnr(reconstruct(input, quick()).volume, truth, static_cast<double>(*high) - *low), 55);
}

TEST(JobPrediction, LeavesOutPartsOnRequest) {
  ReconstructionInput input = gappedInput();
  const auto everything = reconstruct(input, quick());
  const auto interpolated = reconstruct(input, quick(PredictionKind::Interpolation));
  input.predictionParts = {.field = false, .learned = false};
  EXPECT_EQ(reconstruct(input, quick()).volume.voxels, interpolated.volume.voxels);
  for (const PredictionParts parts : {PredictionParts{.field = false}, PredictionParts{.learned = false},
                                      PredictionParts{.startWeights = false}}) {
    input.predictionParts = parts;
    const auto without = reconstruct(input, quick());
    EXPECT_NE(without.volume.voxels, everything.volume.voxels);
    EXPECT_NE(without.volume.voxels, interpolated.volume.voxels);
    EXPECT_EQ(without.prediction.find("a field") == std::string::npos, !parts.field) << without.prediction;
    EXPECT_EQ(without.prediction.find("learned from") == std::string::npos, !parts.learned)
        << without.prediction;
  }
}

TEST(JobPrediction, IsOneFieldForVolumePlanesAndPoints) {
  const auto result = reconstruct(gappedInput(), quick());
  const GaussianField& field = result.model->field;
  const GridGeometry& g = result.volume.geometry;
  std::vector<Vec3> points;
  std::vector<float> values;
  for (std::int64_t n = 0; n < 200; ++n) {
    const std::int64_t v = n * 7919 % g.voxelCount();
    const std::int64_t i = v % g.size[0], j = v / g.size[0] % g.size[1], k = v / (g.size[0] * g.size[1]);
    points.push_back(g.indexToWorld()({double(i), double(j), double(k)}));
    values.push_back(result.volume.voxels[v]);
  }
  const std::vector<float> found = renderPoints(field, points);
  for (std::size_t n = 0; n < points.size(); ++n)
    EXPECT_NEAR(found[n], values[n], 2e-3);
}

TEST(JobPrediction, IsTheSameWithAnyNumberOfThreads) {
  Settings settings = quick();
  settings.threads = 1;
  const auto one = reconstruct(gappedInput(), settings);
  for (const int threads : {2, 5}) {
    settings.threads = threads;
    const auto several = reconstruct(gappedInput(), settings);
    EXPECT_TRUE(sameField(one.model->field, several.model->field)) << threads;
    EXPECT_EQ(one.volume.voxels, several.volume.voxels) << threads;
    EXPECT_EQ(one.prediction, several.prediction);
  }
}

TEST(JobPrediction, ByPresetBalancedIsTheSameWithAnyNumberOfThreads) {
  Settings settings = quick();
  settings.preset = Preset::Balanced;
  settings.threads = 1;
  const auto one = reconstruct(gappedInput(), settings);
  settings.threads = 3;
  const auto several = reconstruct(gappedInput(), settings);
  EXPECT_TRUE(sameField(one.model->field, several.model->field));
  EXPECT_EQ(one.volume.voxels, several.volume.voxels);
  EXPECT_EQ(one.prediction, several.prediction);
}

TEST(JobPrediction, OfTheFitThatJudgesNeverSeesTheSlicesHeldOut) {
  const auto squaredError = [](float added) { // of a rendering, which must not depend on what is added
    ReconstructionInput input = gappedInput();
    input.heldOutFraction = 0.25; // the slices 2, 6 and 10 of 12
    Volume& image = input.stacks[0].image;
    const std::int64_t plane = image.geometry.size[0] * image.geometry.size[1];
    for (const std::int64_t k : {2, 6, 10})
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v)
        image.voxels[static_cast<std::size_t>(v)] += added;
    const auto result = reconstruct(input, quick());
    EXPECT_FALSE(result.prediction.empty());
    EXPECT_EQ(result.heldOutSlices, 3);
    return std::pow(10, -0.1 * result.heldOutPsnr);
  };
  const double none = squaredError(0), more = squaredError(500), less = squaredError(-500);
  EXPECT_NEAR((more + less - 2 * none) / (squaredError(1000) + squaredError(-1000) - 2 * none), 0.25, 1e-4);
  EXPECT_GT(more, 2 * none);
}

// Single slices are missing all over the scan: every fifth, as where the quality is judged.
TEST(JobPrediction, LearnsAcrossMissingSlices) {
  const GridGeometry filled = grid(56, 52, 4 * 24, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));
  // Edges that lean across the slices.
  const Volume truth = volumeOf(filled, [](float i, float j, float k) {
    const float a = std::sin((i + 0.6f * k) / 3.2f), b = std::sin((j - 0.5f * k) / 3.6f);
    return 100 + 60 * std::tanh(3 * a) + 40 * std::tanh(3 * b);
  });
  ReconstructionInput input = inputOf({simulateThickStack(truth, 2, 4)});
  input.outputGrid = filled;
  holdOut(input.stacks[0], {2, 7, 12, 17, 22});
  const auto errorWith = [&](PredictionKind kind) {
    const Volume result = reconstruct(input, quick(kind)).volume;
    const std::int64_t plane = std::int64_t{56} * 52;
    double squares = 0;
    for (const std::int64_t k : {2, 7, 12, 17})
      for (std::int64_t v = 4 * k * plane; v < 4 * (k + 1) * plane; ++v)
        squares += std::pow(static_cast<double>(result.voxels[v]) - truth.voxels[v], 2);
    return std::sqrt(squares / static_cast<double>(16 * plane));
  };
  EXPECT_LT(errorWith(PredictionKind::Auto), 0.9 * errorWith(PredictionKind::Interpolation));
}

TEST(JobPrediction, NeverSeesHeldOutOrMaskedVoxels) {
  ReconstructionInput input = gappedInput();
  Stack& stack = input.stacks.front();
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  holdOut(stack, {5});
  for (std::int64_t v = 0; v < plane / 3; ++v)
    stack.observed[2 * plane + v] = 0;
  const auto before = reconstruct(input, quick());
  for (std::size_t v = 0; v < stack.observed.size(); ++v)
    if (!stack.observed[v]) stack.image.voxels[v] = v % 2 ? 1e5f : -1e5f;
  const auto after = reconstruct(input, quick());
  EXPECT_EQ(before.volume.voxels, after.volume.voxels);
  for (const float v : after.volume.voxels)
    ASSERT_TRUE(std::isfinite(v));
}

TEST(JobPrediction, CostsMoreWithMoreLearningAndLessPerThread) {
  const ReconstructionInput input = gappedInput();
  const Stack& scan = input.stacks.front();
  const GridGeometry filled = candidateGrid(scan.image.geometry, defaultOutputGrid(input.stacks));
  const auto cost = [&](Preset preset, int threads = 2) {
    Settings settings = quick();
    settings.preset = preset;
    settings.threads = threads;
    return predictionCost(scan, filled, settings);
  };
  const PredictionCost fast = cost(Preset::Fast), balanced = cost(Preset::Balanced),
                       best = cost(Preset::Best);
  EXPECT_GT(balanced.learning, 1.5 * fast.learning);
  EXPECT_GT(best.learning, 3 * balanced.learning);
  EXPECT_NEAR(cost(Preset::Fast, 1).fit, 2 * fast.fit, 1e-9 * fast.fit);
  EXPECT_LT(cost(Preset::Best, 16).learning, best.learning);
  EXPECT_GT(cost(Preset::Best, 16).learning, 0.5 * best.learning) << "two threads learn at most";
  Settings interpolated = quick(PredictionKind::Interpolation);
  const PredictionCost little = predictionCost(scan, filled, interpolated);
  EXPECT_EQ(little.trial + little.trialField + little.learning + little.field, 0);
  EXPECT_GT(little.choosing, 0);
}

TEST(JobPrediction, ShowsProgressInProportionToCosts) {
  const ReconstructionInput input = gappedInput();
  const Stack& scan = input.stacks.front();
  for (const PredictionKind kind : {PredictionKind::Interpolation, PredictionKind::Auto}) {
    const PredictionCost cost = predictionCost(
        scan, candidateGrid(scan.image.geometry, defaultOutputGrid(input.stacks)), quick(kind));
    const double predicting =
        cost.choosing + cost.trialField + cost.trial + cost.learning + cost.field + cost.mixing;
    double last = 0, predicted = 0;
    ReconstructionJob job(input, quick(kind));
    job.onProgress([&](const Progress& p) {
      EXPECT_GE(p.fraction, last);
      last = p.fraction;
      if (p.phase == Phase::Predicting) predicted = p.fraction;
    });
    job.run();
    EXPECT_NEAR(predicted, predicting / (predicting + cost.fit), 0.02);
    EXPECT_EQ(last, 1);
  }
}

TEST(JobPrediction, StopsInItsOwnPhase) {
  for (const double share : {0.05, 0.2, 0.4}) {
    const auto stopped =
        runUntil([&](const Progress& p) { return p.phase == Phase::Predicting && p.fraction >= share; },
                 gappedInput(), quick())
            .result;
    ASSERT_TRUE(stopped.cancelled);
    EXPECT_TRUE(stopped.model->field.gaussians.empty());
  }
}

TEST(JobPrediction, GoesOnToTheSameResult) {
  const auto whole = reconstruct(gappedInput(), quick());
  ReconstructionInput again = gappedInput();
  again.resume = runUntil([](const Progress& p) { return p.phase == Phase::Predicting && p.fraction >= 0.2; },
                          gappedInput(), quick())
                     .result.model;
  EXPECT_TRUE(sameField(reconstruct(again, quick()).model->field, whole.model->field));
  const auto stopped = stoppedAt(5, gappedInput(), quick());
  ASSERT_TRUE(stopped.cancelled);
  again.resume = stopped.model;
  const auto resumed = reconstruct(again, quick());
  EXPECT_TRUE(sameField(resumed.model->field, whole.model->field));
  again.resume = resumed.model; // complete: only the residual grid is made again
  EXPECT_TRUE(sameField(reconstruct(again, quick()).model->field, whole.model->field));
}

TEST(JobPrediction, FallsBackInASentence) {
  const auto expect = [](const ReconstructionInput& input, const std::string& reason) {
    SCOPED_TRACE(reason);
    ReconstructionResult result = reconstruct(input, quick());
    EXPECT_NE(result.prediction.find("interpolation"), std::string::npos) << result.prediction;
    EXPECT_NE(result.prediction.find(reason), std::string::npos) << result.prediction;
    return result.volume;
  };
  for (const int slices : {3, 5}) {
    ReconstructionInput few = gappedInput();
    Stack& stack = few.stacks.front();
    stack.image.geometry.size[2] = slices;
    stack.image.voxels.resize(static_cast<std::size_t>(stack.image.geometry.voxelCount()));
    expect(few, std::to_string(slices) + " are too few");
  }
  ReconstructionInput six = gappedInput();
  six.stacks[0].image.geometry.size[2] = 6;
  six.stacks[0].image.voxels.resize(static_cast<std::size_t>(six.stacks[0].image.geometry.voxelCount()));
  expect(six, "too few for every second one to be held out");
  const Volume truth = phantom(grid(72, 72, 105, {1, 1, 1}));
  expect(inputOf({keepEvery(truth, 2, 13)}), "13 pixels apart, and more than 12 are too many");
  const Volume narrow = phantom(grid(20, 72, 45, {1, 1, 1}));
  expect(inputOf({keepEvery(narrow, 2, 4)}), "too few pixels");
  ReconstructionInput constant = gappedInput();
  std::fill(constant.stacks[0].image.voxels.begin(), constant.stacks[0].image.voxels.end(), 7.f);
  for (const float v : expect(constant, "the image shows too little to judge it by").voxels)
    ASSERT_NEAR(v, 7, 1e-4);
  ReconstructionInput labels = gappedInput();
  for (float& v : labels.stacks[0].image.voxels)
    v = v > 50 ? 1.f : 0.f;
  for (const float v : expect(labels, "the image is constant, or one of labels").voxels)
    ASSERT_TRUE(v >= 0 && v <= 1);
}

// At twice such a distance, slices are too far apart to be a scan of their own.
TEST(JobPrediction, WeighsLearningWhereSlicesAreFarApart) {
  const auto result = reconstruct(inputOf({keepEvery(phantom(grid(72, 72, 64, {1, 1, 1})), 2, 7)}), quick());
  EXPECT_EQ(result.prediction.find("Nothing was learned"), std::string::npos) << result.prediction;
}

TEST(JobPrediction, LeavesOtherFitsAlone) {
  for (const ReconstructionInput& input : {isotropicInput(), orthogonalInput()}) {
    const auto asked = reconstruct(input, quickSettings()), none = [&] {
      Settings settings = quickSettings();
      settings.prediction = PredictionKind::None;
      return reconstruct(input, settings);
    }();
    EXPECT_TRUE(asked.prediction.empty());
    EXPECT_TRUE(sameField(asked.model->field, none.model->field));
  }
  Settings additive = quickSettings();
  additive.blending = Blending::Additive;
  EXPECT_TRUE(reconstruct(anisotropicInput(), additive).prediction.empty());
}

} // namespace
} // namespace innergs::testing
