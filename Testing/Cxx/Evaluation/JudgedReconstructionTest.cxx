#include "Evaluation/JudgedReconstruction.h"
#include "Evaluation/HeldOutProtocol.h"

#include "../Core/JobInputs.h"
#include "../Core/ThrownError.h"

#include <cmath>

using namespace innergs;
using namespace innergs::testing;

namespace {

struct JudgedAttempt {
  JudgedResult result;
  std::vector<Progress> states;
};

/// Requests a stop in the first report for which `when` holds.
JudgedAttempt runUntil(const std::function<bool(const Progress&)>& when, const ReconstructionInput& input,
                       std::optional<int> keepEvery) {
  JudgedAttempt run;
  std::stop_source stop;
  JudgedReconstruction job(input, quickSettings(8), keepEvery);
  job.onProgress([&](const Progress& p) {
    run.states.push_back(p);
    if (when && when(p)) stop.request_stop();
  });
  run.result = job.run(stop.get_token());
  return run;
}

Mask lowerHalf() {
  Mask mask{smallGrid(), std::vector<std::uint8_t>(static_cast<std::size_t>(smallGrid().voxelCount()), 1)};
  std::fill(mask.voxels.begin() + mask.voxels.size() / 2, mask.voxels.end(), std::uint8_t{0});
  return mask;
}

} // namespace

TEST(JudgedReconstruction, GivesTheFullFitAndProtocolHOfTheFirstStackInsideTheMask) {
  ReconstructionInput input = isotropicInput();
  input.masks = {lowerHalf()};
  const JudgedAttempt run = runUntil({}, input, 2);
  const auto full = reconstruct(input, quickSettings(8));
  EXPECT_TRUE(sameField(run.result.reconstruction.model->field, full.model->field));
  EXPECT_EQ(run.result.reconstruction.volume.voxels, full.volume.voxels);
  EXPECT_EQ(run.result.reconstruction.judging, Judging::Done);
  EvaluationOptions options;
  options.settings = quickSettings(8);
  options.mask = input.masks.front();
  HeldOutCase heldOut;
  heldOut.factor = 2;
  heldOut.axis = 2;
  const EvaluationReport direct = evaluateHeldOut(input.stacks.front().image, heldOut, options);
  ASSERT_TRUE(run.result.quality);
  ASSERT_EQ(run.result.quality->methods.size(), direct.methods.size());
  for (std::size_t m = 0; m < direct.methods.size(); ++m) {
    EXPECT_EQ(run.result.quality->methods[m].name, direct.methods[m].name);
    EXPECT_EQ(run.result.quality->methods[m].psnr, direct.methods[m].psnr);
    EXPECT_EQ(run.result.quality->methods[m].ssim, direct.methods[m].ssim);
  }
}

TEST(JudgedReconstruction, TellsOfTheSecondFitAsAPhaseOfItsOwn) {
  const JudgedAttempt run = runUntil({}, isotropicInput(), 2);
  double fraction = 0, fitted = 0;
  int phase = 0, most = 0;
  for (const Progress& p : run.states) {
    EXPECT_GE(p.fraction, fraction);
    EXPECT_GE(static_cast<int>(p.phase), phase);
    fraction = p.fraction;
    phase = static_cast<int>(p.phase);
    if (p.phase == Phase::Fitting) fitted = p.loss;
    if (p.phase != Phase::Judging) continue;
    EXPECT_EQ(p.loss, fitted) << "of the model that is delivered";
    EXPECT_LE(p.iteration, p.iterations);
    most = std::max(most, p.iteration);
  }
  EXPECT_EQ(most, 8);
  EXPECT_EQ(run.states.back().phase, Phase::Done);
  EXPECT_EQ(run.states.back().iteration, 8);
  EXPECT_EQ(std::count_if(run.states.begin(), run.states.end(),
                          [](const Progress& p) { return p.phase == Phase::Done; }),
            1);
}

TEST(JudgedReconstruction, StoppedWhileJudgingKeepsTheFit) {
  const auto full = reconstruct(isotropicInput(), quickSettings(8));
  const std::vector<std::function<bool(const Progress&)>> moments{
      [](const Progress& p) { return p.phase == Phase::Judging; },
      [](const Progress& p) { return p.phase == Phase::Judging && p.iteration == 5; },
      [fitted = false](const Progress& p) mutable { // during interpolation
        fitted = fitted || (p.phase == Phase::Judging && p.iterations > 0);
        return fitted && p.iterations == 0;
      }};
  for (const auto& moment : moments) {
    const JudgedAttempt run = runUntil(moment, isotropicInput(), 2);
    const ReconstructionResult& result = run.result.reconstruction;
    EXPECT_FALSE(result.cancelled);
    EXPECT_EQ(result.judging, Judging::Stopped);
    EXPECT_FALSE(run.result.quality);
    EXPECT_TRUE(sameField(result.model->field, full.model->field));
    EXPECT_EQ(result.volume.voxels, full.volume.voxels);
    ASSERT_EQ(result.warnings.size(), 1u);
    EXPECT_NE(result.warnings[0].find("stopped"), std::string::npos);
  }
  const JudgedAttempt before =
      runUntil([](const Progress& p) { return p.phase == Phase::Fitting; }, isotropicInput(), 2);
  EXPECT_TRUE(before.result.reconstruction.cancelled);
  EXPECT_EQ(before.result.reconstruction.judging, Judging::NotAsked);
}

TEST(JudgedReconstruction, WhatCannotBeJudgedIsDeliveredWithTheReason) {
  ReconstructionInput input = isotropicInput();
  const JudgedAttempt run = runUntil({}, input, 20); // of 20 slices
  EXPECT_EQ(run.result.reconstruction.judging, Judging::Failed);
  EXPECT_FALSE(run.result.quality);
  EXPECT_FALSE(run.result.reconstruction.volume.voxels.empty());
  ASSERT_EQ(run.result.reconstruction.warnings.size(), 1u);
  EXPECT_NE(run.result.reconstruction.warnings[0].find("too few"), std::string::npos);
  EXPECT_EQ(run.states.back().phase, Phase::Done);
  for (const int wrong : {1, 65, -2})
    EXPECT_EQ(test::codeOf([&] { JudgedReconstruction(input, quickSettings(2), wrong).run(); }),
              ErrorCode::InvalidArgument)
        << wrong;
}

// What was measured on slices that lie elsewhere would say nothing of the result.
TEST(JudgedReconstruction, SlicesAtPosesOfTheirOwnAreNotComparedWithInterpolation) {
  ReconstructionInput input = isotropicInput();
  Stack& stack = input.stacks.front();
  for (std::int64_t k = 0; k < stack.image.geometry.size[2]; ++k)
    stack.poses.push_back({{}, {0, 0.1 * static_cast<double>(k), 0}});
  EXPECT_EQ(fitOutlines(input, 2).size(), 1u);
  input.heldOutFraction = 0.2;
  const JudgedAttempt run = runUntil({}, input, 2);
  EXPECT_EQ(run.result.reconstruction.judging, Judging::Failed);
  EXPECT_FALSE(run.result.quality);
  EXPECT_FALSE(run.result.reconstruction.volume.voxels.empty());
  EXPECT_TRUE(std::isfinite(run.result.reconstruction.heldOutPsnr));
  ASSERT_FALSE(run.result.reconstruction.warnings.empty());
  EXPECT_NE(run.result.reconstruction.warnings.back().find("hold out slices instead"), std::string::npos);
  EXPECT_EQ(run.states.back().phase, Phase::Done);
}

TEST(JudgedReconstruction, JudgesInBothWaysAtOnce) {
  ReconstructionInput input = isotropicInput();
  input.heldOutFraction = 0.25;
  const JudgedAttempt run = runUntil({}, input, 2);
  const ReconstructionResult& result = run.result.reconstruction;
  EXPECT_EQ(result.judging, Judging::Done);
  EXPECT_EQ(result.heldOutSlices, 5);
  EXPECT_TRUE(run.result.quality);
  EXPECT_EQ(run.states.back().heldOutPsnr, result.heldOutPsnr);
  const JudgedAttempt stopped =
      runUntil([](const Progress& p) { return p.phase == Phase::Judging && p.iteration == 3; }, input, 2);
  EXPECT_EQ(stopped.result.reconstruction.judging, Judging::Stopped);
  EXPECT_FALSE(stopped.result.quality);
  EXPECT_EQ(stopped.result.reconstruction.warnings.size(), 1u) << "said once";
  EXPECT_EQ(fitOutlines(input, 2).size(), 2u);
  EXPECT_EQ(fitOutlines(input, {}).size(), 1u);
}
