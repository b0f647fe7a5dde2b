#include "Core/Job/JobInput.h"
#include "JobInputs.h"
#include "Prediction/SpherePhantom.h"

namespace innergs {
namespace {

using testing::fastSettings;
using testing::psnr;
using testing::reconstruct;

/// Two orthogonal thick-slice scans; before the second, the patient moved by `shift` mm and the receiver gain
/// changed.
ReconstructionInput twoScans(const Volume& truth, double shift, float gain) {
  ReconstructionInput input =
      testing::inputOf({simulateThickStack(truth, 2, 4), simulateThickStack(truth, 0, 4)});
  input.stacks[1].image.geometry.origin[1] += shift;
  for (float& v : input.stacks[1].image.voxels)
    v *= gain;
  input.stacks[0].name = "first.nii";
  input.stacks[1].name = "second.nii";
  input.outputGrid = truth.geometry;
  return input;
}

TEST(JobAlign, MakesUpForMotionAndGainBetweenScansAndSaysSo) {
  const Volume truth = testing::spherePhantom(40, 40, 3);
  const auto psnrOf = [&](const ReconstructionInput& input, bool align) {
    Settings settings = fastSettings();
    settings.align = align;
    return psnr(reconstruct(input, settings).volume, truth);
  };
  const double still = psnrOf(twoScans(truth, 0, 1), true);
  EXPECT_EQ(still, psnrOf(twoScans(truth, 0, 1), false)) << "scans that agree are left alone";
  const ReconstructionInput moved = twoScans(truth, 1.5, 1.1f);
  const double off = psnrOf(moved, false);
  const ReconstructionResult result = reconstruct(moved, fastSettings());
  EXPECT_GT(psnr(result.volume, truth), off + 2);
  EXPECT_GT(psnr(result.volume, truth), still - 1.5);
  ASSERT_EQ(result.alignment.size(), 2u);
  EXPECT_NEAR(result.alignment[1].toOthers.offset[1], -1.5, 0.2);
  EXPECT_NEAR(result.alignment[1].gain, 1 / 1.1, 0.01);
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_EQ(result.warnings[0].find("second.nii was moved by 1."), 0u) << result.warnings[0];
}

TEST(JobAlign, LeavesAScanOfAnotherBodyWhereItIs) {
  ReconstructionInput input = twoScans(testing::spherePhantom(48, 48, 3), 0, 1);
  input.stacks[1] = simulateThickStack(testing::spherePhantom(48, 48, 9), 0, 4);
  input.stacks[1].name = "other.nii";
  const ReconstructionResult result = reconstruct(input, fastSettings());
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_EQ(result.warnings[0].find("other.nii does not fit the other scans"), 0u) << result.warnings[0];
  EXPECT_EQ(result.alignment.at(1).toOthers, Affine3{});
  EXPECT_FALSE(result.sliceMotion.moved);
  Settings settings = fastSettings();
  settings.align = false;
  settings.sliceMotion = SliceMotionKind::Off;
  const ReconstructionResult off = reconstruct(input, settings);
  EXPECT_EQ(result.volume.voxels, off.volume.voxels) << "as it was scanned";
  ASSERT_EQ(off.warnings.size(), 1u) << "it is named whatever is switched off";
  EXPECT_EQ(off.warnings[0].find("other.nii does not fit the other scans"), 0u) << off.warnings[0];
}

TEST(JobAlign, SaysHowWellScansAgreeBeforeAndAfterTheFit) {
  const ReconstructionInput input = twoScans(testing::spherePhantom(48, 48, 3), 0, 1);
  for (const bool align : {true, false}) {
    Settings settings = fastSettings();
    settings.align = align;
    if (!align) settings.sliceMotion = SliceMotionKind::Off;
    const ReconstructionResult result = reconstruct(input, settings);
    EXPECT_TRUE(result.warnings.empty());
    ASSERT_EQ(result.agreement.size(), 2u);
    for (const StackAgreement& a : result.agreement) {
      EXPECT_TRUE(a.fits);
      EXPECT_NEAR(a.fittedPsnr, result.trainingPsnr, 4);
    }
    EXPECT_GT(result.agreement[1].psnr, 20);
    const std::string said = agreementSentence(result.agreement);
    EXPECT_EQ(said.find("The scans agree"), 0u) << said;
    EXPECT_NE(said.find("which it was fitted to, at "), std::string::npos) << said;
  }
  ReconstructionInput one = input;
  one.stacks.pop_back();
  EXPECT_TRUE(reconstruct(one, fastSettings()).agreement.empty());
}

TEST(JobAlign, SaysByHowMuchAScanOnAnotherScaleWasMultiplied) {
  const ReconstructionResult result =
      reconstruct(twoScans(testing::spherePhantom(48, 48, 3), 0, 1e5f), fastSettings());
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("multiplied by 1e-05"), std::string::npos) << result.warnings[0];
}

TEST(JobAlign, SaysThatANearlyBlankScanCannotBeCompared) {
  ReconstructionInput input = twoScans(testing::spherePhantom(48, 48, 3), 0, 0);
  EXPECT_THROW((void)reconstruct(input, fastSettings()), Error); // shows nothing
  input.stacks[1].image.voxels[0] = 1;
  const ReconstructionResult result = reconstruct(input, fastSettings());
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_EQ(result.warnings[0].find("second.nii shares too little with the other scans"), 0u)
      << result.warnings[0];
}

TEST(JobAlign, SeesNoHeldOutSlice) {
  const Volume truth = testing::spherePhantom(48, 48, 3);
  ReconstructionInput input = twoScans(truth, 1.5, 1);
  input.heldOutFraction = 0.2;
  const PreparedInput before = prepareInput(input, {}, true);
  ReconstructionInput changed = input;
  for (const std::int64_t k : before.heldOut[1])
    for (std::int64_t v = k * 48 * 48; v < (k + 1) * 48 * 48; ++v)
      changed.stacks[1].image.voxels[v] = 5e3f;
  ThreadPool pool(2);
  const auto aligned = [&](const ReconstructionInput& of) {
    std::vector<StackAlignment> found;
    prepareInput(of, {}, true, [&](std::span<Stack> stacks) {
      found = alignStacks(stacks, pool);
      return std::vector<std::string>{};
    });
    return found.at(1).toOthers;
  };
  EXPECT_EQ(aligned(input), aligned(changed));
}

} // namespace
} // namespace innergs
