#include "Core/Render/Render.h"
#include "JobInputs.h"

#include <limits>

using namespace innergs;
using namespace innergs::testing;

class Job : public ::testing::TestWithParam<InputKind> {
protected:
  ReconstructionInput input = GetParam().input();
};

TEST_P(Job, IsTheSameForAnyNumberOfThreads) {
  Settings settings = quickSettings();
  settings.preset = Preset::Balanced; // several members if the data call for them
  settings.threads = 1;
  const auto one = reconstruct(input, settings);
  ASSERT_FALSE(one.cancelled);
  ASSERT_GT(one.model->field.size(), 20);
  for (int threads : {2, 3, 5}) {
    settings.threads = threads;
    const auto other = reconstruct(input, settings);
    EXPECT_TRUE(sameField(one.model->field, other.model->field)) << threads << " threads";
    EXPECT_EQ(one.volume.voxels, other.volume.voxels) << threads << " threads";
    EXPECT_EQ(one.trainingPsnr, other.trainingPsnr);
  }
}

TEST_P(Job, FollowsTheSeed) {
  Settings settings = quickSettings(5);
  settings.seed = 7;
  const auto a = reconstruct(input, settings), b = reconstruct(input, settings);
  EXPECT_TRUE(sameField(a.model->field, b.model->field));
  EXPECT_EQ(a.volume.voxels, b.volume.voxels);
  settings.seed = 8;
  EXPECT_FALSE(sameField(a.model->field, reconstruct(input, settings).model->field));
}

TEST_P(Job, ImprovesOnItsStart) {
  const Volume truth = phantom(smallGrid());
  input.outputGrid = truth.geometry;
  std::vector<double> losses;
  std::vector<Progress> states;
  ReconstructionJob job(input, quickSettings(30));
  job.onProgress([&](const Progress& p) { states.push_back(p); });
  const auto result = job.run();
  ASSERT_GT(states.size(), 20u);
  double fraction = 0;
  int phase = 0, fitting = 0;
  for (const Progress& p : states) {
    EXPECT_GE(p.fraction, fraction);
    EXPECT_LE(p.fraction, 1);
    EXPECT_GE(static_cast<int>(p.phase), phase) << "phases come in their order";
    EXPECT_GE(p.elapsed, 0);
    EXPECT_GE(p.remaining, 0);
    EXPECT_LE(p.iteration, p.iterations);
    EXPECT_STRNE(phaseName(p.phase), "");
    fraction = p.fraction;
    phase = static_cast<int>(p.phase);
    if (p.phase == Phase::Fitting) {
      ++fitting;
      losses.push_back(p.loss);
      EXPECT_GT(p.gaussians, 0);
    }
  }
  EXPECT_EQ(states.front().phase, Phase::Preparing);
  EXPECT_EQ(states.back().phase, Phase::Done);
  EXPECT_EQ(states.back().fraction, 1);
  EXPECT_EQ(fitting, result.iterations);
  EXPECT_LT(losses.back(), 0.5 * losses.front());
  EXPECT_GT(psnr(result.volume, truth), 20);
  EXPECT_GT(result.trainingPsnr, 20);
  EXPECT_TRUE(std::isnan(result.heldOutPsnr)) << "nothing was held out";
  EXPECT_EQ(result.judging, Judging::NotAsked);
  EXPECT_TRUE(result.settings.gaussians && result.settings.iterations && result.settings.linearIntensity);
  EXPECT_EQ(result.instructionSet, instructionSets().front());
  EXPECT_GT(result.seconds, 0);
  EXPECT_TRUE(sameGrid(result.model->field.domain, truth.geometry));
}

TEST_P(Job, AgreesBetweenInstructionSets) {
  const Volume truth = phantom(smallGrid());
  input.outputGrid = truth.geometry;
  std::vector<double> quality;
  for (const std::string& set : instructionSets()) {
    Settings settings = quickSettings(15);
    settings.instructionSet = set;
    settings.consistency = false; // compares the Gaussians alone
    const auto result = reconstruct(input, settings);
    EXPECT_EQ(result.instructionSet, set);
    quality.push_back(psnr(result.volume, truth));
  }
  for (double q : quality)
    EXPECT_NEAR(q, quality.back(), 0.3);
}

TEST_P(Job, WithEveryLossAndBlendingFits) {
  const Volume truth = phantom(smallGrid());
  input.outputGrid = truth.geometry;
  for (const Blending blending : {Blending::Normalised, Blending::Additive})
    for (const LossKind loss : {LossKind::L1, LossKind::L2, LossKind::Huber})
      for (const double ssim : {0.0, 0.05}) {
        if (ssim > 0 && loss != LossKind::L2) continue;
        SCOPED_TRACE(::testing::Message() << int(blending) << int(loss) << ssim);
        Settings settings = quickSettings(25);
        settings.blending = blending;
        settings.loss = loss;
        settings.ssimWeight = ssim;
        const auto result = reconstruct(input, settings);
        EXPECT_GT(psnr(result.volume, truth), 16);
        EXPECT_EQ(result.model->field.blending, blending);
      }
}

INSTANTIATE_TEST_SUITE_P(Inputs, Job,
                         ::testing::Values(InputKind{"Isotropic", isotropicInput},
                                           InputKind{"Anisotropic", anisotropicInput},
                                           InputKind{"Orthogonal", orthogonalInput}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(JobStart, AsAnEvenGridFits) {
  Settings settings = quickSettings(20);
  settings.initialisation = Initialisation::Grid;
  const auto input = isotropicInput();
  EXPECT_GT(psnr(reconstruct(input, settings).volume, input.stacks[0].image), 20);
}

TEST(JobOfAConstant, IsThatConstant) {
  for (const double value : {0.0, 1000.0, -1024.0}) {
    ReconstructionInput input;
    input.stacks.emplace_back().image = volumeOf(grid(12, 11, 10), [&](auto, auto, auto) { return value; });
    const auto result = reconstruct(input, quickSettings(8));
    EXPECT_FALSE(result.cancelled);
    ASSERT_EQ(result.volume.voxels.size(), 1320u);
    for (float v : result.volume.voxels)
      ASSERT_NEAR(v, value, 1e-3);
  }
}

TEST(JobOfBrokenVoxels, CountsAndIgnoresThem) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  ReconstructionInput input = isotropicInput();
  const Volume truth = input.stacks[0].image;
  auto& voxels = input.stacks[0].image.voxels;
  std::int64_t broken = 0;
  for (std::size_t v = 5; v < voxels.size(); v += 37, ++broken)
    voxels[v] = broken % 3 == 0 ? nan : broken % 3 == 1 ? inf : -inf;
  const auto result = reconstruct(input, quickSettings(30));
  EXPECT_EQ(result.nonFiniteVoxels, broken);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings[0].find(std::to_string(broken)), std::string::npos);
  for (float v : result.volume.voxels)
    ASSERT_TRUE(std::isfinite(v));
  EXPECT_GT(psnr(result.volume, truth), 20) << "the broken voxels are filled from their neighbours";
}

TEST(JobOfRepeatedSlices, SaysSo) {
  ReconstructionInput input = isotropicInput();
  Volume& scan = input.stacks[0].image;
  const std::int64_t plane = scan.geometry.size[0] * scan.geometry.size[1];
  for (const std::int64_t k : {5, 9})
    std::copy_n(scan.voxels.begin() + (k - 1) * plane, plane, scan.voxels.begin() + k * plane);
  input.stacks[0].name = "knee";
  const auto result = reconstruct(input, quickSettings(8));
  ASSERT_EQ(result.warnings.size(), 1u);
  EXPECT_NE(result.warnings[0].find("2 of the "), std::string::npos) << result.warnings[0];
  EXPECT_NE(result.warnings[0].find("knee repeat the slice before"), std::string::npos) << result.warnings[0];
}

TEST(JobOfTwoSlices, Works) {
  ReconstructionInput input;
  input.stacks.emplace_back().image = phantom(grid(20, 18, 2, {1, 1, 3}));
  const auto result = reconstruct(input, quickSettings(15));
  EXPECT_FALSE(result.cancelled);
  EXPECT_EQ(result.volume.geometry.size[2], 6);
  for (float v : result.volume.voxels)
    ASSERT_TRUE(std::isfinite(v));
}

TEST(JobWithAMask, FitsOnlyInside) {
  ReconstructionInput input = isotropicInput();
  Mask mask{smallGrid(), {}};
  for (std::int64_t v = 0; v < mask.geometry.voxelCount(); ++v)
    mask.voxels.push_back(v % 24 < 12);
  input.masks = {mask};
  const auto result = reconstruct(input, quickSettings(15));
  // Nothing outside may matter.
  ReconstructionInput other = input;
  for (std::size_t v = 0; v < other.stacks[0].image.voxels.size(); ++v)
    if (!mask.voxels[v]) other.stacks[0].image.voxels[v] += 77;
  EXPECT_TRUE(sameField(result.model->field, reconstruct(other, quickSettings(15)).model->field));
}

TEST(JobWithTheStopRule, EndsAConvergedFitEarly) {
  const ReconstructionInput input = inputOf(
      {pointStack(volumeInSpace(grid(10, 10, 10), [](const Vec3& x) { return 100 + 5 * x[0] + 3 * x[1]; }))});
  Settings settings = quickSettings();
  settings.iterations.reset();
  settings.gaussians = 60;
  settings.paperStopRule = true;
  const auto result = reconstruct(input, settings);
  EXPECT_GE(result.iterations, 100);
  EXPECT_LT(result.iterations, 1000);
  EXPECT_GT(result.trainingPsnr, 25);
}

TEST(JobPreview, ShowsTheOutputGridAtReducedSize) {
  ReconstructionInput input = isotropicInput();
  Settings settings = quickSettings(1'000'000);
  int previews = 0;
  std::stop_source stop;
  ReconstructionJob job(input, settings);
  job.onPreview([&](const Volume& volume) {
    ++previews;
    EXPECT_LE(*std::max_element(volume.geometry.size.begin(), volume.geometry.size.end()), 96);
    EXPECT_EQ(static_cast<std::int64_t>(volume.voxels.size()), volume.geometry.voxelCount());
    EXPECT_GT(psnr(volume, input.stacks[0].image), 15);
    stop.request_stop();
  });
  const auto result = job.run(stop.get_token());
  EXPECT_EQ(previews, 1);
  EXPECT_TRUE(result.cancelled);
}
