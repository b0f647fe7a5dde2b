// Several scans that do not go together as they should.
#include "Alignment/HeadPhantom.h"
#include "Core/Job/ReconstructionRun.h"
#include "JobInputs.h"
#include "Prediction/SpherePhantom.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs {
namespace {

using testing::psnr;
using testing::reconstruct;

constexpr std::int64_t kWidth = 48;

/// Two scans of 4 mm slices at right angles, each of its own volume on the same grid.
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

/// Three still scans of a head, each shaded in its own way.
ReconstructionInput shadedScans() {
  const Volume truth = testing::headPhantom(56);
  ReconstructionInput input;
  input.outputGrid = truth.geometry;
  for (int s = 0; s < 3; ++s) {
    Stack stack = simulateThickStack(truth, 2 - s, 4, 1, static_cast<std::uint64_t>(s) + 1);
    const GridGeometry& g = stack.image.geometry;
    const Affine3 map = g.indexToWorld();
    for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
      const Vec3 x = map({static_cast<double>(v % g.size[0]), static_cast<double>(v / g.size[0] % g.size[1]),
                          static_cast<double>(v / (g.size[0] * g.size[1]))});
      const double u = x[s] / 28 - 1, w = x[(s + 1) % 3] / 28 - 1;
      stack.image.voxels[v] *= static_cast<float>(1 + 0.35 * (0.8 * u - 0.4 * w * w + 0.2));
    }
    stack.name = std::array{"ax", "cor", "sag"}[s];
    input.stacks.push_back(std::move(stack));
  }
  return input;
}

TEST(JobStacks, ThatAreShadedAreNotMovedToMakeUpForIt) {
  const ReconstructionInput input = shadedScans();
  const ReconstructionResult result = reconstruct(input, quick());
  EXPECT_FALSE(result.sliceMotion.moved);
  for (const StackAlignment& a : result.alignment)
    EXPECT_EQ(a.displacement, 0);
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_NE(result.warnings.back().find("look shaded differently"), std::string::npos)
      << result.warnings.back();
  EXPECT_TRUE(result.bias.scans.empty()) << "nothing was corrected";
  for (const StackAgreement& a : result.agreement)
    EXPECT_TRUE(a.fits) << a.correlation;
}

TEST(JobStacks, CanKeepTheShadingOfTheFirst) {
  const ReconstructionInput input = shadedScans();
  Settings settings = quick();
  settings.biasField = BiasFieldKind::Auto;
  const ReconstructionResult flat = reconstruct(input, settings);
  settings.keepBias = true;
  const ReconstructionResult kept = reconstruct(input, settings);
  ASSERT_EQ(kept.bias.scans.size(), 3u);
  const Affine3 map = kept.volume.geometry.indexToWorld();
  const auto& n = kept.volume.geometry.size;
  double squared = 0, shading = 0, count = 0;
  for (std::int64_t v = 0; v < kept.volume.geometry.voxelCount(); v += 7) {
    const double own = flat.volume.voxels[v];
    if (own < 60) continue;
    const double log = kept.bias.scans[0].field.logAt(
        map({static_cast<double>(v % n[0]), static_cast<double>(v / n[0] % n[1]),
             static_cast<double>(v / (n[0] * n[1]))}));
    squared += std::pow(std::log(kept.volume.voxels[v] / own) - log, 2);
    shading += log * log;
    ++count;
  }
  ASSERT_GT(count, 500);
  EXPECT_LT(squared, 0.1 * shading);
  EXPECT_TRUE(std::any_of(kept.warnings.begin(), kept.warnings.end(), [](const std::string& said) {
    return said.find("With the same shading, that of ax") != std::string::npos;
  }));
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

TEST(JobStacks, WithPosesGetAResidualOnlyWhereThesePosesWereFound) {
  ReconstructionInput input = scansOf(body(3), body(3));
  Affine3 shifted;
  shifted.offset = {0.5, 0, 0};
  for (Stack& stack : input.stacks)
    stack.poses.assign(static_cast<std::size_t>(stack.image.geometry.size[2]), shifted);
  Settings settings = quick();
  settings.iterations = 2;
  const auto hasResidual = [&](bool found) {
    ReconstructionRun run(input, settings, false, {});
    if (found) run.treatPosesAsFound();
    return !run.run({}, false).model->field.residual.voxels.empty();
  };
  EXPECT_FALSE(hasResidual(false));
  EXPECT_TRUE(hasResidual(true));
}

TEST(JobStacks, GivenTwiceAreAsGoodAsOnce) {
  const Volume truth = body(3);
  ReconstructionInput twice = scansOf(truth, truth);
  const double once = psnr(reconstruct(twice, quick()).volume, truth);
  twice.stacks.push_back(twice.stacks[1]);
  const ReconstructionResult result = reconstruct(twice, quick());
  EXPECT_GT(psnr(result.volume, truth), once - 1);
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
  EXPECT_GT(psnr(result.volume, truth), still - 11);
}

} // namespace
} // namespace innergs
