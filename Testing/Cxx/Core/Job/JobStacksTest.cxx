// Several scans that do not go together as they should.
#include "JobInputs.h"
#include "Prediction/SpherePhantom.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

using testing::psnr;
using testing::reconstruct;

constexpr std::int64_t kWidth = 48;

/// Two scans of 4 mm slices at right angles, each of its own volume on the same lattice.
ReconstructionInput scansOf(const Volume& first, const Volume& second) {
  ReconstructionInput input =
      testing::inputOf({simulateThickStack(first, 2, 4), simulateThickStack(second, 0, 4)});
  input.stacks[0].name = "first.nii";
  input.stacks[1].name = "second.nii";
  input.outputGrid = first.geometry;
  return input;
}

Settings quick(bool align = true) {
  Settings settings = testing::fastSettings();
  settings.align = align;
  if (!align) settings.sliceMotion = SliceMotionKind::Off;
  return settings;
}

Volume body(std::uint64_t seed) {
  return testing::spherePhantom(kWidth, kWidth, seed);
}

TEST(JobStacks, OfDifferentBodiesAreSaidSoAndLeftWhereTheyLie) {
  const ReconstructionInput input = scansOf(body(3), body(11));
  const ReconstructionResult result = reconstruct(input, quick());
  ASSERT_EQ(result.alignment.size(), 2u);
  EXPECT_FALSE(result.alignment[1].fits);
  EXPECT_TRUE(std::any_of(result.warnings.begin(), result.warnings.end(), [](const std::string& warning) {
    return warning.find("second.nii") != std::string::npos && warning.find("not fit") != std::string::npos;
  }));
  EXPECT_FALSE(result.sliceMotion.moved);
  EXPECT_EQ(result.volume.voxels, reconstruct(input, quick(false)).volume.voxels);
}

/// The volume three times, each with other noise of this standard deviation.
ReconstructionInput repeated(const Volume& truth, double noise) {
  ReconstructionInput input;
  input.outputGrid = truth.geometry;
  for (const std::uint64_t seed : {1, 2, 3}) {
    Stack& scan = input.stacks.emplace_back(testing::pointStack(truth));
    addNoise(scan.image.voxels, noise, seed);
  }
  return input;
}

TEST(JobStacks, ThatRepeatAnIsotropicOneAreNoWorseThanTheirMean) {
  Volume truth = body(3);
  for (std::size_t v = 0; v < truth.voxels.size(); ++v) { // finer than so few Gaussians can show
    const std::size_t i = v % kWidth, j = v / kWidth % kWidth, k = v / kWidth / kWidth;
    truth.voxels[v] += 20 * std::sin(1.1f * static_cast<float>(i)) * std::sin(1.2f * static_cast<float>(j)) *
                       std::cos(static_cast<float>(k));
  }
  const ReconstructionInput input = repeated(truth, 4);
  Volume mean{truth.geometry, std::vector<float>(truth.voxels.size(), 0.f)};
  for (const Stack& scan : input.stacks)
    for (std::size_t v = 0; v < mean.voxels.size(); ++v)
      mean.voxels[v] += scan.image.voxels[v] / 3;
  Settings settings = quick();
  EXPECT_GT(psnr(reconstruct(input, settings).volume, truth), psnr(mean, truth));
  settings.consistency = false; // what the residual grid is for
  EXPECT_LT(psnr(reconstruct(input, settings).volume, truth), psnr(mean, truth) - 1);
}

// The residual grid, with cubic voxels, must hold what the Gaussians miss, not what a grid blurs of them.
TEST(JobStacks, OfVoxelsThatAreNotCubesLoseNothingByTheirResidual) {
  Volume truth = body(3);
  truth.geometry.spacing[1] *= 1.3;
  const ReconstructionInput input = repeated(truth, 4);
  Settings settings = quick();
  settings.preset = Preset::Balanced;
  settings.iterations = 80;
  const double with = psnr(reconstruct(input, settings).volume, truth);
  settings.consistency = false;
  EXPECT_GT(with, psnr(reconstruct(input, settings).volume, truth) - 0.05);
}

TEST(JobStacks, OfWildlyDifferentIntensitiesAreScaled) {
  const Volume truth = body(3);
  ReconstructionInput input = scansOf(truth, truth);
  const double same = psnr(reconstruct(input, quick()).volume, truth);
  for (const float factor : {300.f, 0.01f}) {
    ReconstructionInput other = input;
    for (float& value : other.stacks[1].image.voxels)
      value *= factor;
    const ReconstructionResult result = reconstruct(other, quick());
    EXPECT_NEAR(result.alignment[1].gain, 1 / factor, 0.02 / factor) << factor;
    EXPECT_GT(psnr(result.volume, truth), same - 0.5) << factor;
  }
}

TEST(JobStacks, WithMovedSlicesAreFittedForLongerWhereTheyAgree) {
  Settings settings = quick();
  settings.sliceMotion = SliceMotionKind::On;
  const auto iterations = [&](std::uint64_t second) {
    const ReconstructionResult result = reconstruct(scansOf(body(3), body(second)), settings);
    EXPECT_TRUE(result.sliceMotion.moved);
    return *result.settings.iterations;
  };
  EXPECT_GT(iterations(3), iterations(11));
}

TEST(JobStacks, WithMovedSlicesMergeFieldsByPresetBalanced) {
  Settings settings = quick();
  settings.preset = Preset::Balanced;
  settings.iterations = 2;
  settings.prediction = PredictionKind::None;
  const auto members = [&](SliceMotionKind kind) {
    settings.sliceMotion = kind;
    const ReconstructionResult result = reconstruct(scansOf(body(3), body(3)), settings);
    EXPECT_EQ(result.sliceMotion.moved, kind == SliceMotionKind::On);
    return *result.settings.ensembleSize;
  };
  EXPECT_EQ(members(SliceMotionKind::On), 3);
  EXPECT_EQ(members(SliceMotionKind::Off), 1);
}

TEST(JobStacks, GivenTwiceAreAsGoodAsOnce) {
  const Volume truth = body(3);
  ReconstructionInput twice = scansOf(truth, truth);
  const double once = psnr(reconstruct(twice, quick()).volume, truth);
  twice.stacks.push_back(twice.stacks[1]);
  const ReconstructionResult result = reconstruct(twice, quick());
  EXPECT_GT(psnr(result.volume, truth), once - 0.5);
  EXPECT_TRUE(result.alignment[2].fits);
  EXPECT_LT(result.alignment[2].displacement, 0.05);
}

TEST(JobStacks, WithSlicesGivenTwiceStayWhole) {
  const Volume truth = body(3);
  ReconstructionInput input = scansOf(truth, truth);
  const double still = psnr(reconstruct(input, quick()).volume, truth);
  Volume& image = input.stacks[0].image;
  const std::int64_t plane = kWidth * kWidth;
  std::copy_n(image.voxels.begin() + 5 * plane, plane,
              image.voxels.begin() + 6 * plane); // one in the wrong place
  const ReconstructionResult result = reconstruct(input, quick());
  EXPECT_TRUE(std::all_of(result.volume.voxels.begin(), result.volume.voxels.end(),
                          [](float value) { return std::isfinite(value); }));
  EXPECT_GT(psnr(result.volume, truth), still - 9);
}

} // namespace
} // namespace innergs
