#include "Core/Job/JobInput.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/ProgressParts.h"
#include "JobInputs.h"

#include <cmath>

using namespace innergs;
using namespace innergs::testing;

namespace {

ReconstructionInput heldOutInput() {
  ReconstructionInput input = isotropicInput();
  input.heldOutFraction = 0.25; // the slices 2, 6, 10, 14, 18 of 20
  return input;
}

} // namespace

TEST(HeldOut, JudgesByASecondFitAndDeliversTheFullOne) {
  const ReconstructionInput input = heldOutInput();
  ReconstructionInput plain = input;
  plain.heldOutFraction = 0;
  const Settings settings = quickSettings(25);
  const auto result = reconstruct(input, settings), full = reconstruct(plain, settings);
  EXPECT_TRUE(sameField(result.model->field, full.model->field));
  EXPECT_EQ(result.model->settingsKey, full.model->settingsKey);
  EXPECT_EQ(result.volume.voxels, full.volume.voxels);
  EXPECT_EQ(result.trainingPsnr, full.trainingPsnr);
  EXPECT_EQ(result.iterations, full.iterations);
  EXPECT_EQ(result.judging, Judging::Done);
  EXPECT_EQ(result.heldOutSlices, 5);
  EXPECT_GT(result.judgingSeconds, 0);
  EXPECT_GE(result.seconds, result.fitSeconds + result.judgingSeconds);
  // Not bit-identical: the second fit starts with as many Gaussians as with no slice held out.
  EXPECT_NEAR(result.heldOutPsnr, psnrOfAFitWithout(input, {2, 6, 10, 14, 18}, settings), 0.5);
  EXPECT_LT(result.heldOutPsnr, full.trainingPsnr);
}

TEST(HeldOut, NothingOfTheHeldOutSlicesReachesTheSecondFit) {
  const Settings settings = quickSettings(12);
  const auto squaredError = [&](float added) { // of a rendering, which must not depend on what is added
    ReconstructionInput input = heldOutInput();
    Volume& image = input.stacks[0].image;
    const std::int64_t plane = image.geometry.size[0] * image.geometry.size[1];
    for (const std::int64_t k : {2, 6, 10, 14, 18})
      for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v)
        image.voxels[v] += added;
    return std::pow(10, -0.1 * reconstruct(input, settings).heldOutPsnr);
  };
  const double none = squaredError(0), more = squaredError(500), less = squaredError(-500);
  EXPECT_NEAR((more + less - 2 * none) / (squaredError(1000) + squaredError(-1000) - 2 * none), 0.25, 1e-4);
  EXPECT_GT(more, 2 * none);
}

TEST(HeldOut, TakesTheSlicesOfEveryStack) {
  ReconstructionInput input = orthogonalInput(); // 5 and 6 slices
  input.heldOutFraction = 0.25;
  const auto result = reconstruct(input, quickSettings(25));
  EXPECT_EQ(result.heldOutSlices, 2);
  EXPECT_GT(result.heldOutPsnr, 10);
  EXPECT_LT(result.heldOutPsnr, 80);
}

TEST(HeldOut, TellsOfItsOwnIterationsAndOfTheTimeOfBoth) {
  const Attempt run = runUntil({}, heldOutInput(), quickSettings(12));
  double fraction = 0;
  Progress fitted;
  std::vector<int> judgingIterations;
  for (const Progress& p : run.states) {
    EXPECT_GE(p.fraction, fraction);
    fraction = p.fraction;
    if (p.phase < Phase::Judging) {
      EXPECT_TRUE(judgingIterations.empty()) << "phases come in their order";
      fitted = p;
      EXPECT_LE(p.fraction, 1 / 1.75 + 1e-9);
    } else if (p.phase == Phase::Judging) {
      judgingIterations.push_back(p.iteration);
      EXPECT_EQ(p.loss, fitted.loss) << "of the model that is delivered";
      EXPECT_EQ(p.trainingPsnr, fitted.trainingPsnr);
      EXPECT_EQ(p.gaussians, fitted.gaussians);
      EXPECT_GE(p.elapsed, fitted.elapsed);
      if (p.fraction < 1) {
        EXPECT_GT(p.remaining, 0);
      }
    }
  }
  ASSERT_GT(judgingIterations.size(), 12u);
  EXPECT_EQ(judgingIterations.front(), 0);
  EXPECT_EQ(judgingIterations.back(), 12);
  EXPECT_TRUE(std::is_sorted(judgingIterations.begin(), judgingIterations.end()));
  EXPECT_EQ(run.states.back().phase, Phase::Done);
  EXPECT_EQ(run.states.back().fraction, 1);
  EXPECT_EQ(run.states.back().remaining, 0);
  EXPECT_EQ(run.states.back().heldOutPsnr, run.result.heldOutPsnr);
}

TEST(HeldOut, StoppedWhileJudgingKeepsTheFit) {
  const ReconstructionInput input = heldOutInput();
  const Attempt whole = runUntil({}, input, quickSettings(6));
  for (const int iteration : {0, 3, 6}) {
    const Attempt run =
        runUntil([&](const Progress& p) { return p.phase == Phase::Judging && p.iteration == iteration; },
                 input, quickSettings(6));
    EXPECT_FALSE(run.result.cancelled);
    EXPECT_EQ(run.result.judging, Judging::Stopped);
    EXPECT_TRUE(std::isnan(run.result.heldOutPsnr));
    EXPECT_TRUE(sameField(run.result.model->field, whole.result.model->field));
    EXPECT_EQ(run.result.volume.voxels, whole.result.volume.voxels);
    ASSERT_EQ(run.result.warnings.size(), 1u);
    EXPECT_NE(run.result.warnings[0].find("stopped"), std::string::npos);
    EXPECT_EQ(run.states.back().phase, Phase::Done);
  }
}

TEST(HeldOut, GoesOnFromAStoppedFitAndThenJudges) {
  ReconstructionInput input = heldOutInput();
  const Attempt whole = runUntil({}, input, quickSettings(8));
  const Attempt stopped =
      runUntil([](const Progress& p) { return p.iteration == 3; }, input, quickSettings(8));
  ASSERT_TRUE(stopped.result.cancelled);
  EXPECT_EQ(stopped.result.judging, Judging::NotAsked);
  EXPECT_GT(stopped.result.fitSeconds, 0) << "of the iterations that were made";
  input.resume = stopped.result.model;
  const auto rest = reconstruct(input, quickSettings(8));
  EXPECT_TRUE(rest.warnings.empty());
  EXPECT_TRUE(sameField(rest.model->field, whole.result.model->field));
  EXPECT_DOUBLE_EQ(rest.heldOutPsnr, whole.result.heldOutPsnr) << "the second fit starts from scratch";
}

TEST(HeldOut, SaysWhyTheQualityIsUnknown) {
  ReconstructionInput two = isotropicInput();
  Stack& stack = two.stacks.front();
  stack.image.geometry.size[2] = 2;
  stack.image.voxels.resize(2 * 24 * 22);
  for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
    stack.image.voxels[v] = static_cast<float>(v % 24);
  two.heldOutFraction = 0.5;
  ReconstructionInput masked = heldOutInput(); // no held-out slice lies inside
  masked.masks = {Mask{smallGrid(), std::vector<std::uint8_t>(24 * 22 * 20, 0)}};
  for (std::int64_t k : {8, 9})
    std::fill_n(masked.masks.front().voxels.begin() + k * 24 * 22, 24 * 22, std::uint8_t{1});
  for (const ReconstructionInput& input : {two, masked}) {
    const auto result = reconstruct(input, quickSettings(3));
    EXPECT_EQ(result.judging, Judging::Failed);
    EXPECT_TRUE(std::isnan(result.heldOutPsnr));
    EXPECT_FALSE(result.volume.voxels.empty());
    ASSERT_FALSE(result.warnings.empty());
    EXPECT_NE(result.warnings.back().find("could not be judged"), std::string::npos);
  }
}

TEST(HeldOut, TinySharesHoldOutOneSlice) {
  ReconstructionInput input = isotropicInput();
  for (const double share : {1e-18, 1e-300, 4.9e-324}) {
    input.heldOutFraction = share;
    EXPECT_EQ(prepareInput(input, {}, true).heldOut[0], std::vector<std::int64_t>{10}) << share;
  }
}

TEST(HeldOut, CountsInTheEstimates) {
  ReconstructionInput input = isotropicInput();
  const std::int64_t once = estimateMemory(input, quickSettings());
  input.heldOutFraction = 0.1;
  EXPECT_EQ(estimateMemory(input, quickSettings()) - once, 4 * smallGrid().voxelCount()); // the first result
}

TEST(ProgressOfParts, CorrectsTheRemainingTimeByWhatPartsTake) {
  std::vector<Progress> told;
  ProgressParts parts([&](const Progress& p) { told.push_back(p); }, {2, 1, 1});
  const auto tell = [](const ProgressCallback& part, double fraction, double elapsed, double remaining) {
    Progress p;
    p.phase = Phase::Fitting;
    p.fraction = fraction;
    p.elapsed = elapsed;
    p.remaining = remaining;
    part(p);
    return p;
  };
  const ProgressCallback first = parts.next();
  tell(first, 0.5, 10, 10);
  EXPECT_DOUBLE_EQ(told.back().fraction, 0.25);
  EXPECT_DOUBLE_EQ(told.back().remaining, 10 + 20) << "the rest weighs as much as the first part";
  tell(first, 1, 20, 0);
  EXPECT_EQ(told.back().phase, Phase::Fitting);
  EXPECT_DOUBLE_EQ(told.back().remaining, 20);
  const ProgressCallback second = parts.next();
  tell(second, 0.01, 1, 0); // too early to extrapolate
  EXPECT_EQ(told.back().phase, Phase::Judging);
  EXPECT_DOUBLE_EQ(told.back().elapsed, 21);
  EXPECT_DOUBLE_EQ(told.back().remaining, 9.9 + 10);
  tell(second, 0.5, 15, 15); // slower than expected
  EXPECT_DOUBLE_EQ(told.back().fraction, 0.625);
  EXPECT_DOUBLE_EQ(told.back().remaining, 15 + 30);
  parts.finish();
  EXPECT_EQ(told.back().phase, Phase::Done);
  EXPECT_EQ(told.back().remaining, 0);
}
