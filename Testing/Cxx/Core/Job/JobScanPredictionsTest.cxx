// What each of several scans shows alone between its slices, mixed into the fit to all.
#include "Core/Job/JobInput.h"
#include "Core/Job/ShareTrial.h"
#include "JobInputs.h"

#include <cmath>

namespace innergs::testing {
namespace {

constexpr std::int64_t kWidth = 36;

/// Two scans of 4 mm slices at right angles.
ReconstructionInput scansOf(const Volume& truth) {
  ReconstructionInput input = inputOf({simulateThickStack(truth, 2, 4), simulateThickStack(truth, 0, 4)});
  input.outputGrid = truth.geometry;
  return input;
}

const GridGeometry kScanGrid = grid(kWidth, kWidth, kWidth, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));

/// Smooth between the slices.
Volume waves() {
  return volumeOf(kScanGrid, [](float i, float j, float k) {
    return 100 + 60 * std::sin(i / 2.2f) * std::sin(j / 2.6f) * std::sin(k / 2.4f);
  });
}

/// Labels: a network blurs their edges.
Volume ball() {
  return volumeOf(kScanGrid, [](float i, float j, float k) {
    const float x = i - 15, y = j - 19, z = k - 17;
    return x * x + y * y + 1.3f * z * z < 130 ? 200.f : 0.f;
  });
}

Settings settingsWith(PredictionKind kind) {
  Settings settings = fastSettings();
  settings.preset = Preset::Balanced;
  settings.iterations = 20;
  settings.align = false;
  settings.sliceMotion = SliceMotionKind::Off;
  settings.prediction = kind;
  return settings;
}

const Settings kNone = settingsWith(PredictionKind::None),
               kQuick = settingsWith(PredictionKind::Interpolation);

bool predicting(const Progress& p) {
  return p.phase == Phase::Predicting;
}

TEST(JobScanPredictions, HelpWhereASimulationSaysSo) {
  const Volume truth = waves();
  const ReconstructionInput input = scansOf(truth);
  const auto without = reconstruct(input, kNone);
  EXPECT_TRUE(without.prediction.empty());
  EXPECT_EQ(without.predictionShare, 0);
  for (const PredictionKind kind : {PredictionKind::Auto, PredictionKind::Interpolation}) {
    const auto with = reconstruct(input, settingsWith(kind));
    EXPECT_GT(with.predictionShare, 0.05);
    EXPECT_LE(with.predictionShare, 0.4);
    EXPECT_NE(with.prediction.find(std::to_string(std::lround(100 * with.predictionShare)) + " %"),
              std::string::npos)
        << with.prediction;
    EXPECT_GT(psnr(with.volume, truth), psnr(without.volume, truth) + 0.5);
  }
}

TEST(JobScanPredictions, AreLeftOutWhereTheyDoNotHelp) {
  const ReconstructionInput input = scansOf(ball());
  const auto with = reconstruct(input, kQuick);
  EXPECT_EQ(with.predictionShare, 0);
  EXPECT_NE(with.prediction.find("left out"), std::string::npos) << with.prediction;
  EXPECT_TRUE(sameField(with.model->field, reconstruct(input, kNone).model->field));
}

TEST(JobScanPredictions, AreLeftOutOfScansTooSmallForASimulation) {
  Volume thin = waves();
  thin.geometry.size[2] = 8;
  thin.voxels.resize(static_cast<std::size_t>(thin.geometry.voxelCount()));
  const auto with = reconstruct(scansOf(thin), kQuick);
  EXPECT_NE(with.prediction.find("too small"), std::string::npos) << with.prediction;
  EXPECT_TRUE(sameField(with.model->field, reconstruct(scansOf(thin), kNone).model->field));
}

TEST(JobScanPredictions, TakeNoPartInOtherFits) {
  const ReconstructionInput still = scansOf(waves());
  const auto takePart = [&](const Settings& settings, const ReconstructionInput& input) {
    return predictsEach(settings, geometryTraits(input.stacks), input.stacks, !input.masks.empty());
  };
  EXPECT_TRUE(takePart(kQuick, still));
  for (void (*change)(Settings&, ReconstructionInput&) :
       {+[](Settings&s, ReconstructionInput&) { s.prediction = PredictionKind::None; },
        +[](Settings&s, ReconstructionInput&) { s.preset = Preset::Fast; },
        +[](Settings&s, ReconstructionInput&) { s.preset = Preset::Paper; },
        +[](Settings&s, ReconstructionInput&) { s.consistency = false; },
        +[](Settings&s, ReconstructionInput&) { s.blending = Blending::Additive; },
        +[](Settings&, ReconstructionInput&input) { input.stacks.pop_back(); },
        +[](Settings&, ReconstructionInput&input) { input.stacks[1] = isotropicInput().stacks[0]; },
        +[](Settings&, ReconstructionInput&input) {
          Stack& stack = input.stacks[0];
          stack.poses.assign(static_cast<std::size_t>(stack.image.geometry.size[2]), Affine3{});
        },
        +[](Settings&, ReconstructionInput&input) { input.masks.emplace_back(); }}) {
    Settings settings = kQuick;
    ReconstructionInput input = still;
    change(settings, input);
    EXPECT_FALSE(takePart(settings, input));
  }
}

TEST(JobScanPredictions, TakeNoPartWhereScansShowDifferentBodies) {
  ReconstructionInput input = scansOf(waves());
  input.stacks[1] = simulateThickStack(ball(), 0, 4);
  Settings settings = kQuick;
  settings.align = true;
  EXPECT_TRUE(reconstruct(input, settings).prediction.empty());
}

TEST(JobScanPredictions, AreTheSameWithAnyNumberOfThreads) {
  Settings settings = kQuick;
  settings.threads = 1;
  const auto one = reconstruct(scansOf(waves()), settings);
  settings.threads = 3;
  const auto several = reconstruct(scansOf(waves()), settings);
  EXPECT_GT(one.predictionShare, 0);
  EXPECT_EQ(one.predictionShare, several.predictionShare);
  EXPECT_TRUE(sameField(one.model->field, several.model->field));
}

TEST(JobScanPredictions, StopAtOnceAndGoOnToTheSameResult) {
  const Attempt whole = runUntil({}, scansOf(waves()), kQuick);
  double before = 0;
  for (const Progress& p : whole.states) {
    EXPECT_GE(p.fraction, before);
    before = p.fraction;
  }
  for (const double share : {0.72, 0.85}) {
    const auto stopped = runUntil([&](const Progress& p) { return predicting(p) && p.fraction >= share; },
                                  scansOf(waves()), kQuick)
                             .result;
    ASSERT_TRUE(stopped.cancelled);
    EXPECT_EQ(stopped.iterations, 20);
    ReconstructionInput again = scansOf(waves());
    again.resume = stopped.model;
    const auto resumed = reconstruct(again, kQuick);
    EXPECT_EQ(resumed.iterationsRun, 0);
    EXPECT_TRUE(sameField(resumed.model->field, whole.result.model->field));
  }
}

TEST(JobScanPredictions, NeverSeeHeldOutSlices) {
  ReconstructionInput input = scansOf(waves());
  Stack& stack = input.stacks.front();
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  holdOut(stack, {5});
  const auto before = reconstruct(input, kQuick);
  EXPECT_GT(before.predictionShare, 0);
  for (std::int64_t v = 5 * plane; v < 6 * plane; ++v)
    stack.image.voxels[static_cast<std::size_t>(v)] = v % 2 ? 1e5f : -1e5f;
  EXPECT_EQ(before.volume.voxels, reconstruct(input, kQuick).volume.voxels);
}

TEST(JobScanPredictions, TakePartInTheFitThatJudges) {
  ReconstructionInput input = scansOf(waves());
  input.heldOutFraction = 0.2;
  const auto with = reconstruct(input, kQuick), without = reconstruct(input, kNone);
  ASSERT_EQ(with.judging, Judging::Done);
  EXPECT_NE(with.heldOutPsnr, without.heldOutPsnr);
}

TEST(ShareTrial, ScansAPartOfTheResult) {
  const Volume truth = waves();
  const std::vector<Stack> stacks = scansOf(truth).stacks;
  ThreadPool pool(2);
  const auto sampled = [&](const GridGeometry& grid) {
    const Affine3 map = inverse(truth.geometry.indexToWorld()) * grid.indexToWorld();
    return volumeOf(grid, [&](double i, double j, double k) { return sampleLinear(truth, map({i, j, k})); });
  };
  const ShareTrial trial = shareTrial(sampled, stacks, dataDomain(stacks), kQuick, 0, pool);
  ASSERT_EQ(trial.refit.input.stacks.size(), stacks.size());
  EXPECT_EQ(trial.truth.geometry.size, trial.refit.input.outputGrid->size);
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    const Stack& scan = trial.refit.input.stacks[s];
    const Affine3 map = inverse(stacks[s].image.geometry.indexToWorld()) * scan.image.geometry.indexToWorld();
    const auto& n = scan.image.geometry.size;
    const Vec3 middle{static_cast<double>(n[0] / 2), static_cast<double>(n[1] / 2),
                      static_cast<double>(n[2] / 2)};
    EXPECT_NEAR(sampleLinear(scan.image, middle), sampleLinear(stacks[s].image, map(middle)), 0.5) << s;
  }
}

TEST(ShareTrial, ChoosesLessThanComesNearest) {
  const Volume unmixed = waves();
  Volume mixed = unmixed, truth = unmixed;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v) {
    const float change = static_cast<float>(v % 7) - 3;
    mixed.voxels[v] += change;
    truth.voxels[v] += 1.5f * change;
  }
  const double nearest = 1.5 * kTriedShare;
  EXPECT_NEAR(chosenShare(truth, unmixed, mixed, 0), nearest - 0.15, 1e-3);
  EXPECT_NEAR(chosenShare(truth, unmixed, mixed, 0.01), nearest - 0.15 - 0.08, 1e-3);
  EXPECT_EQ(chosenShare(truth, unmixed, mixed, 0.05), 0);
  EXPECT_EQ(chosenShare(truth, unmixed, unmixed, 0), 0);
}

} // namespace
} // namespace innergs::testing
