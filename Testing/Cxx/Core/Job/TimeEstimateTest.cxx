#include "Core/Job/TimeEstimate.h"
#include "Core/Job/MemoryEstimate.h"

#include "JobInputs.h"

namespace innergs::testing {
namespace {

/// Only the grid, as before a start.
ReconstructionInput outline(std::int64_t side, double gap = 1) {
  ReconstructionInput input;
  Stack stack;
  stack.image.geometry = grid(side, side, side, {1, 1, gap}, {-30, 12, 5}, obliqueDirection(0.3));
  input.stacks.push_back(stack);
  return input;
}

Settings threaded(Preset preset = Preset::Fast) {
  Settings settings;
  settings.preset = preset;
  settings.threads = 2;
  settings.device = "cpu";
  return settings;
}

/// An estimator whose fits take the times set here.
struct TimeEstimate : ::testing::Test {
  double perVoxel = 1e-6;       // seconds per iteration; a coarse one takes a quarter
  double perOutputVoxel = 1e-7; // seconds
  double start = 0;             // seconds per voxel
  double perMultiply = 1e-11;   // seconds per multiply-add
  int trials = 0;
  bool aligned = false; // in a trial
  TimeEstimator estimator{[this](const ReconstructionInput& small, const Settings& settings, int) {
                            ++trials;
                            aligned = aligned || settings.align || settings.biasField != BiasFieldKind::Off ||
                                      settings.sliceMotion != SliceMotionKind::Off;
                            const auto voxels =
                                static_cast<double>(small.stacks.front().image.geometry.voxelCount());
                            TrialTimes t;
                            t.start = start * voxels;
                            t.fine = perVoxel * voxels;
                            t.coarse = 0.25 * t.fine;
                            t.render = perOutputVoxel * static_cast<double>(small.outputGrid->voxelCount());
                            t.total = t.start + 2 * t.fine + 2 * t.coarse + t.render;
                            return t;
                          },
                          [this](const std::string&) { return perMultiply; }};
};

TEST_F(TimeEstimate, GrowsWithIterationsAndMembersInProportion) {
  const ReconstructionInput input = outline(40);
  perOutputVoxel = 0;
  Settings settings = threaded();
  settings.iterations = 2000;
  const double one = estimator.seconds(input, settings);
  const double everyFine = 2000 * perVoxel * 40 * 40 * 40;
  EXPECT_LE(one, 1.0001 * everyFine);
  EXPECT_GT(one, 0.25 * everyFine) << "some are coarse";
  settings.ensembleSize = 3;
  EXPECT_NEAR(estimator.seconds(input, settings), 3 * one, 1e-9 * one);
  ReconstructionInput judged = input;
  judged.heldOutFraction = 0.25;
  EXPECT_NEAR(estimator.seconds(judged, settings), 1.75 * 3 * one, 1e-9 * one);
}

TEST_F(TimeEstimate, GrowsWithTheVolumeInProportion) {
  Settings settings = threaded();
  settings.iterations = 100;
  EXPECT_NEAR(estimator.seconds(outline(160), settings), 8 * estimator.seconds(outline(80), settings), 1e-6);
}

TEST_F(TimeEstimate, CountsWhatTheNetworkMultiplies) {
  const ReconstructionInput input = outline(60, 4);
  Settings settings = threaded(Preset::Balanced);
  perMultiply = 0;
  const double fit = estimator.seconds(input, settings);
  perMultiply = 1e-11;
  const double two = estimator.seconds(input, settings) - fit;
  EXPECT_GT(two, 0);
  perMultiply = 3e-11;
  EXPECT_NEAR(estimator.seconds(input, settings) - fit, 3 * two, 1e-6 * two);
  settings.threads = 16; // a training step has two parts
  const double sixteen = estimator.seconds(input, settings) - fit;
  EXPECT_GT(sixteen, 3 * two / 8);
  EXPECT_LT(sixteen, 3 * two);
  settings.prediction = PredictionKind::Interpolation;
  EXPECT_LE(estimator.seconds(input, settings), fit);
}

TEST_F(TimeEstimate, CountsTheFieldThatNoisySlicesAreAveragedWith) {
  ReconstructionInput input = outline(80, 4);
  const double unknown = estimator.seconds(input, threaded());
  Volume& image = input.stacks.front().image;
  image = phantom(image.geometry);
  EXPECT_EQ(estimator.seconds(input, threaded()), unknown);
  addNoise(image.voxels, 10, 1);
  Settings settings = threaded();
  EXPECT_GT(estimator.seconds(input, settings), unknown);
  settings.prediction = PredictionKind::Interpolation;
  const double noisy = estimator.seconds(input, settings);
  image.voxels.clear();
  EXPECT_EQ(noisy, estimator.seconds(input, settings));
}

TEST_F(TimeEstimate, CountsTheAlignmentOfScansApartFromTheFit) {
  ReconstructionInput input = outline(80, 4);
  input.stacks.push_back(input.stacks.front());
  Settings settings = threaded();
  const double both = estimator.seconds(input, settings);
  EXPECT_FALSE(aligned) << "in a piece too small to tell what it takes";
  settings.sliceMotion = SliceMotionKind::Off;
  const double wholes = estimator.seconds(input, settings);
  settings.align = false;
  const double none = estimator.seconds(input, settings);
  EXPECT_GT(both, 1.1 * wholes);
  EXPECT_GT(wholes, 1.1 * none);
  input.stacks.pop_back();
  settings.prediction = PredictionKind::None;
  const double one = estimator.seconds(input, settings);
  settings.align = true;
  EXPECT_EQ(estimator.seconds(input, settings), one) << "one scan is not aligned";
}

TEST_F(TimeEstimate, CountsSlicesThatMove) {
  ReconstructionInput input = outline(80, 4);
  input.stacks.push_back(input.stacks.front());
  input.stacks.back().image.geometry.direction =
      withSliceAxis(input.stacks.back().image.geometry, 0).direction;
  Settings settings = threaded(Preset::Balanced);
  settings.prediction = PredictionKind::None; // which still scans that lie beside each other would have
  settings.align = false;
  settings.iterations = 60;
  const double still = estimator.seconds(input, settings);
  settings.sliceMotion = SliceMotionKind::On;
  EXPECT_GT(estimator.seconds(input, settings), 1.5 * still);
}

TEST_F(TimeEstimate, CountsTheSimulationOfTheUncertaintyWhichIsAsLongForAnyScan) {
  Settings settings = threaded();
  settings.iterations = 100;
  const auto simulation = [&](std::int64_t side) {
    ReconstructionInput judged = outline(side);
    judged.heldOutFraction = 0.2;
    ReconstructionInput uncertain = outline(side);
    uncertain.uncertainty = true; // holds out as many
    return estimator.seconds(uncertain, settings) - estimator.seconds(judged, settings);
  };
  const double small = simulation(140);
  EXPECT_NEAR(small, simulation(280), 1e-6 * small);
  perOutputVoxel = 0;
  settings.iterations = 10'000;
  EXPECT_NEAR(simulation(140), 1.8 * estimator.seconds(outline(96), settings), 0.05 * simulation(140))
      << "two fits of 96 voxels across";
}

TEST_F(TimeEstimate, IsThatOfWhatTheMaskHolds) {
  ReconstructionInput input = outline(60);
  perOutputVoxel = 0;
  Settings settings = threaded();
  settings.iterations = 100;
  const double whole = estimator.seconds(input, settings);
  input.masks = {Mask{input.stacks[0].image.geometry, {}}};
  EXPECT_EQ(estimator.seconds(input, settings), whole) << "its voxels are not known";
  input.masks.front().voxels.resize(60 * 60 * 60);
  std::fill_n(input.masks.front().voxels.begin(), 60 * 60 * 15, std::uint8_t{1});
  EXPECT_NEAR(estimator.seconds(input, settings), 0.25 * whole, 1e-6 * whole);
  const Settings best = threaded(Preset::Best);
  EXPECT_LT(estimateMemory(input, best), estimateMemory(outline(60), best));
}

TEST(TimeEstimateOfThisMachine, IsForEverySettingAboveZero) {
  for (const Preset preset : {Preset::Fast, Preset::Balanced, Preset::Best, Preset::Paper})
    for (const double gap : {1.0, 4.0}) {
      const double seconds = estimateSeconds(outline(60, gap), threaded(preset));
      EXPECT_TRUE(std::isfinite(seconds) && seconds > 0) << static_cast<int>(preset) << " " << gap;
    }
  EXPECT_GT(estimateSeconds(orthogonalInput(), threaded()), 0);
}

TEST_F(TimeEstimate, IsRemembered) {
  const ReconstructionInput input = outline(300);
  const double first = estimator.seconds(input, threaded(Preset::Balanced));
  const int before = trials;
  perVoxel *= 2;
  EXPECT_EQ(estimator.seconds(input, threaded(Preset::Balanced)), first);
  EXPECT_EQ(trials, before);
  EXPECT_GT(estimator.seconds(outline(300, 2), threaded(Preset::Balanced)), 0);
  EXPECT_GT(trials, before) << "another spacing";
}

TEST_F(TimeEstimate, RendersLittleForAFineOutput) {
  ReconstructionInput input = outline(40);
  Settings settings = threaded();
  settings.iterations = 1;
  perVoxel = 0;
  input.outputGrid = withSpacing(input.stacks[0].image.geometry, {0.05, 0.05, 0.05});
  const auto voxels = static_cast<double>(input.outputGrid->voxelCount());
  // Would need more memory than available if it were rendered completely.
  EXPECT_NEAR(estimator.seconds(input, settings), perOutputVoxel * voxels, 1e-9 * voxels);
}

TEST_F(TimeEstimate, IsMadeAgainWhenAJobRanBeside) {
  const ReconstructionInput input = outline(44);
  const Settings settings = threaded();
  double beside = 0;
  int during = 0;
  ReconstructionJob job(isotropicInput(), quickSettings(4));
  job.onProgress([&](const Progress& p) {
    if (p.phase != Phase::Fitting || beside > 0) return;
    beside = estimator.seconds(input, settings);
    during = trials;
    EXPECT_EQ(estimator.seconds(input, settings), beside) << "as good as it gets";
    EXPECT_EQ(trials, during);
  });
  job.run();
  ASSERT_GT(beside, 0);
  perVoxel *= 0.5; // the disturbance is over
  const double alone = estimator.seconds(input, settings);
  EXPECT_GT(trials, during);
  EXPECT_LT(alone, beside);
  const int after = trials;
  EXPECT_EQ(estimator.seconds(input, settings), alone);
  EXPECT_EQ(trials, after);
}

TEST_F(TimeEstimate, RefusesWhatTheJobWouldRefuse) {
  Settings settings = threaded();
  EXPECT_THROW(estimator.seconds({}, settings), Error);
  settings.iterations = -1;
  EXPECT_THROW(estimator.seconds(outline(20), settings), Error);
  ReconstructionInput flat = outline(20);
  flat.stacks[0].image.geometry.spacing[1] = 0;
  EXPECT_THROW(estimator.seconds(flat, threaded()), Error);
}

} // namespace
} // namespace innergs::testing
