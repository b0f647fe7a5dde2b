#include "Core/Job/TimeEstimate.h"

#include "JobInputs.h"

#include <chrono>

namespace innergs::testing {
namespace {

/// The lattice alone, as before a start.
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

TEST(TimeEstimate, GrowsWithSweepsAndMembersInProportion) {
  const ReconstructionInput input = outline(40);
  Settings settings = threaded();
  settings.iterations = 20;
  const double few = estimateSeconds(input, settings);
  settings.iterations = 2000;
  const double many = estimateSeconds(input, settings);
  settings.ensembleSize = 3;
  const double members = estimateSeconds(input, settings);
  EXPECT_GT(few, 0);
  EXPECT_TRUE(std::isfinite(many));
  EXPECT_GT(many, 10 * few);
  EXPECT_GT(members, 2.5 * many);
  EXPECT_LT(members, 3.5 * many);
}

TEST(TimeEstimate, GrowsWithTheVolumeAndIsForEverySettingAboveZero) {
  EXPECT_GT(estimateSeconds(outline(160), threaded()), 5 * estimateSeconds(outline(48), threaded()));
  for (const Preset preset : {Preset::Fast, Preset::Balanced, Preset::Best, Preset::Paper})
    for (const double gap : {1.0, 4.0}) {
      const double seconds = estimateSeconds(outline(60, gap), threaded(preset));
      EXPECT_TRUE(std::isfinite(seconds) && seconds > 0) << static_cast<int>(preset) << " " << gap;
      EXPECT_LT(seconds, 1e5);
    }
  ReconstructionInput crossed = orthogonalInput();
  EXPECT_GT(estimateSeconds(crossed, threaded()), 0);
}

TEST(TimeEstimate, IsRemembered) {
  const Settings settings = threaded(Preset::Balanced);
  const ReconstructionInput input = outline(300);
  const double first = estimateSeconds(input, settings);
  EXPECT_EQ(estimateSeconds(input, settings), first) << "no two timings are the same to the last bit";
}

TEST(TimeEstimate, RendersLittleForAFineOutput) {
  ReconstructionInput input = outline(40);
  const double coarse = estimateSeconds(input, threaded());
  input.outputGrid = withSpacing(input.stacks[0].image.geometry, {0.05, 0.05, 0.05});
  const double fine = estimateSeconds(input, threaded()); // more memory than there is, were it all rendered
  EXPECT_GT(fine, 20 * coarse) << "8000 times the voxels to render";
}

TEST(TimeEstimate, IsMadeAgainWhenAJobRanBeside) {
  const ReconstructionInput input = outline(44);
  const Settings settings = threaded();
  double beside = 0;
  ReconstructionJob job(isotropicInput(), quickSettings(4));
  job.onProgress([&](const Progress& p) {
    if (p.phase != Phase::Fitting || beside > 0) return;
    beside = estimateSeconds(input, settings);
    EXPECT_EQ(estimateSeconds(input, settings), beside) << "as good as it gets";
  });
  job.run();
  ASSERT_GT(beside, 0);
  const auto begun = std::chrono::steady_clock::now();
  const double alone = estimateSeconds(input, settings);
  const double timing = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  EXPECT_GT(timing, 5e-4) << "timed again";
  EXPECT_GT(alone, 0);
  EXPECT_EQ(estimateSeconds(input, settings), alone);
}

TEST(TimeEstimate, RefusesWhatTheJobWouldRefuse) {
  Settings settings = threaded();
  EXPECT_THROW(estimateSeconds({}, settings), Error);
  settings.iterations = -1;
  EXPECT_THROW(estimateSeconds(outline(20), settings), Error);
  ReconstructionInput flat = outline(20);
  flat.stacks[0].image.geometry.spacing[1] = 0;
  EXPECT_THROW(estimateSeconds(flat, threaded()), Error);
}

} // namespace
} // namespace innergs::testing
