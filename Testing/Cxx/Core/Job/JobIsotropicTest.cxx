// One scan whose voxels are cubes: nothing has to be invented between its slices.
#include "Core/Fit/Plan.h"
#include "JobInputs.h"

#include <cmath>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// With detail that so few Gaussians do not show.
Volume scene(const GridGeometry& geometry) {
  return volumeInSpace(geometry, [](const Vec3& x) {
    return 100 + 40 * std::sin(0.2 * x[0]) * std::cos(0.25 * x[1]) +
           15 * std::sin(1.1 * x[0]) * std::sin(1.2 * x[1]) * std::cos(x[2]);
  });
}

ReconstructionInput scanOf(const Volume& volume) {
  ReconstructionInput input = inputOf({pointStack(volume)});
  input.outputGrid = volume.geometry;
  return input;
}

Settings without(Settings settings) {
  settings.consistency = false;
  return settings;
}

const GridGeometry kGrid = grid(32, 30, 28, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));

TEST(JobIsotropic, ShowsTheScanOnItsOwnVoxels) {
  const Volume truth = scene(kGrid);
  const ReconstructionResult result = reconstruct(scanOf(truth), quickSettings());
  EXPECT_GT(psnr(result.volume, truth), 100);
  EXPECT_TRUE(sameGrid(result.model->field.residual.geometry, kGrid));
  const ReconstructionResult alone = reconstruct(scanOf(truth), without(quickSettings()));
  EXPECT_LT(psnr(alone.volume, truth), 40);
  EXPECT_TRUE(alone.model->field.residual.voxels.empty());
}

TEST(JobIsotropic, LosesNoiseAndNothingElse) {
  const Volume truth = phantom(kGrid);
  for (const double noise : {2.0, 6.0}) {
    Volume noisy = truth;
    innergs::addNoise(noisy.voxels, noise, std::uint64_t{3});
    const double with = psnr(reconstruct(scanOf(noisy), quickSettings()).volume, truth);
    EXPECT_GT(with, psnr(noisy, truth)) << noise;
    EXPECT_GT(with, psnr(reconstruct(scanOf(noisy), without(quickSettings())).volume, truth)) << noise;
  }
}

TEST(JobIsotropic, NoisyScansAreFittedForFewerIterations) {
  Settings settings = quickSettings();
  settings.preset = Preset::Balanced;
  settings.iterations.reset();
  const Volume clean = scene(kGrid);
  Volume noisy = clean;
  innergs::addNoise(noisy.voxels, 10, std::uint64_t{3});
  const auto iterations = [&](const Volume& volume, const Settings& given) {
    const IntensityMap map = chooseIntensityMap(scanOf(volume).stacks);
    Settings filled = given;
    return makePlan(filled, measureTraits(scanOf(volume).stacks, map)).iterations;
  };
  EXPECT_EQ(iterations(clean, settings), 200);
  EXPECT_EQ(iterations(noisy, settings), 30);
  EXPECT_EQ(iterations(noisy, without(settings)), 200); // no residual grid keeps the rest
  const double fitted = psnr(reconstruct(scanOf(noisy), settings).volume, clean);
  Settings longer = settings;
  longer.iterations = 200;
  EXPECT_EQ(iterations(noisy, longer), 200);
  EXPECT_GT(fitted, psnr(reconstruct(scanOf(noisy), longer).volume, clean) - 0.05);
}

TEST(JobIsotropic, OnFinerVoxelsIsBetterThanLinearInterpolation) {
  const Volume scan = scene(kGrid), truth = scene(withSpacing(kGrid, {0.5, 0.5, 0.5}));
  ReconstructionInput input = scanOf(scan);
  input.outputGrid = truth.geometry;
  Volume linear = truth;
  const Affine3 map = inverse(scan.geometry.indexToWorld()) * truth.geometry.indexToWorld();
  const auto& n = truth.geometry.size;
  for (std::int64_t v = 0; v < truth.geometry.voxelCount(); ++v)
    linear.voxels[v] =
        sampleLinear(scan, map({double(v % n[0]), double(v / n[0] % n[1]), double(v / n[0] / n[1])}));
  EXPECT_GT(psnr(reconstruct(input, quickSettings()).volume, truth), psnr(linear, truth) + 3);
}

TEST(JobIsotropic, HeldOutVoxelsTeachNothing) {
  ReconstructionInput input = scanOf(scene(kGrid));
  holdOut(input.stacks[0], {9});
  ReconstructionInput other = input;
  const std::size_t plane = 32 * 30;
  std::fill_n(other.stacks[0].image.voxels.begin() + 9 * plane, plane, 100.f);
  EXPECT_EQ(reconstruct(input, quickSettings()).volume.voxels,
            reconstruct(other, quickSettings()).volume.voxels);
}

TEST(JobIsotropic, ThePapersFieldsAreGaussiansAlone) {
  Settings settings = quickSettings(3);
  settings.blending = Blending::Alpha;
  EXPECT_TRUE(reconstruct(scanOf(scene(kGrid)), settings).model->field.residual.voxels.empty());
  settings = quickSettings(3);
  settings.blending = Blending::Additive;
  EXPECT_TRUE(reconstruct(scanOf(scene(kGrid)), settings).model->field.residual.voxels.empty());
}

} // namespace
