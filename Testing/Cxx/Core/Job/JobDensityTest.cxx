#include "Core/Fit/Plan.h"
#include "Core/Image/Region.h"
#include "JobInputs.h"
#include "ThrownError.h"

using namespace innergs;
using namespace innergs::testing;

/// The number of Gaussians and the quality of a fit, for any part of the scans.
namespace {

Settings defaults(int iterations = 20) {
  Settings settings = quickSettings(iterations);
  settings.gaussians.reset();
  settings.consistency = false; // tests the Gaussians alone
  return settings;
}

Mask ballOf(const GridGeometry& geometry, double radius) {
  return maskInSpace(geometry, [&](const Vec3& x) { return norm(x - geometry.centre()) < radius; });
}

double insidePsnr(const Volume& image, const Volume& truth, const Mask& mask) {
  double sum = 0, count = 0;
  for (std::size_t v = 0; v < truth.voxels.size(); ++v)
    if (mask.voxels[v]) {
      sum += std::pow(static_cast<double>(image.voxels[v]) - truth.voxels[v], 2);
      ++count;
    }
  return 10 * std::log10(200 * 200 * count / sum);
}

/// The phantom on a grid large enough for a preset's own budget.
Volume head() {
  return phantom(grid(40, 38, 36, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3)));
}

void expectAsGoodInside(ReconstructionInput input, const Volume& truth, const Settings& settings) {
  input.outputGrid = truth.geometry;
  const ReconstructionResult whole = reconstruct(input, settings);
  for (const double radius : {9.0, 13.0}) {
    const Mask mask = ballOf(truth.geometry, radius);
    input.masks = {mask};
    const ReconstructionResult part = reconstruct(input, settings);
    EXPECT_LT(*part.settings.gaussians, *whole.settings.gaussians);
    EXPECT_GT(insidePsnr(part.volume, truth, mask), insidePsnr(whole.volume, truth, mask) - 0.3)
        << "radius " << radius << ", " << *part.settings.gaussians << " of " << *whole.settings.gaussians
        << " Gaussians";
  }
}

} // namespace

TEST(JobDensity, AMaskedFitIsAsGoodInside) {
  const ReconstructionInput input = inputOf({pointStack(head())});
  for (const Initialisation start : {Initialisation::Adaptive, Initialisation::Grid}) {
    Settings settings = defaults(40);
    settings.initialisation = start;
    expectAsGoodInside(input, input.stacks.front().image, settings);
  }
}

TEST(JobDensity, AMaskedFitLosesNoSmallLabels) {
  const Volume labels = volumeOf(head().geometry, [](auto i, auto j, auto k) {
    return i % 7 < 2 && j % 7 < 2 && k % 7 < 2 ? 40.0 * static_cast<double>(1 + (i / 7 + j / 7 + k / 7) % 5)
                                               : 0.0;
  });
  ReconstructionInput input = inputOf({pointStack(labels)});
  const Mask mask = ballOf(labels.geometry, 13);
  input.masks = {mask};
  input.outputGrid = labels.geometry;
  Settings settings = defaults(200);
  settings.gaussians = 500;
  const ReconstructionResult part = reconstruct(input, settings);
  std::int64_t lost = 0;
  for (std::size_t v = 0; v < mask.voxels.size(); ++v)
    lost += mask.voxels[v] && labels.voxels[v] > 0 && part.volume.voxels[v] < 1;
  EXPECT_EQ(lost, 0);
}

TEST(JobDensity, AMaskedFitOfThickSlicesIsAsGoodInside) {
  const Volume truth = head();
  ReconstructionInput input = inputOf({simulateThickStack(truth, 2, 4)});
  const Settings settings = defaults();
  expectAsGoodInside(input, truth, settings);
  input.stacks.push_back(simulateThickStack(truth, 0, 4));
  expectAsGoodInside(input, truth, settings);
}

TEST(JobDensity, HeldOutSlicesLeaveTheBudget) {
  for (ReconstructionInput input : {isotropicInput(), anisotropicInput(), orthogonalInput()}) {
    const Settings whole = reconstruct(input, defaults(2)).settings;
    input.heldOutFraction = 0.2;
    EXPECT_EQ(reconstruct(input, defaults(2)).settings.gaussians, whole.gaussians);
  }
}

TEST(JobDensity, TheOrderOfTheInputsDoesNotMatter) {
  const Volume truth = head();
  const Stack large = simulateThickStack(truth, 2, 2);
  Stack small = simulateThickStack(phantom(grid(12, 10, 12, {1, 1, 1}, {-20, 20, 15})), 0, 3);
  for (const bool masked : {false, true}) {
    ReconstructionInput one, other;
    one.stacks = {large, small};
    other.stacks = {small, large};
    if (masked) one.masks = other.masks = {ballOf(truth.geometry, 12)};
    Settings settings = defaults(2);
    const auto budget = [&](const ReconstructionInput& input) {
      return static_cast<double>(*reconstruct(input, settings).settings.gaussians);
    };
    // Predicted, as they mostly lie beside each other: the mask's box depends on the axes of the first.
    EXPECT_NEAR(budget(one), budget(other), masked ? 0.2 * budget(one) : 0);
    settings.prediction = PredictionKind::None;
    EXPECT_EQ(budget(one), budget(other)) << masked;
    if (!masked) {
      EXPECT_GT(budget(one), 40 * 38 * 36 / 60); // one per 50 voxels of the larger one
    }
  }
}

// The box of a mask may be a small part of what is predicted.
TEST(JobDensity, FollowsTheMaskOfASingleScanToo) {
  const Volume truth = head();
  ReconstructionInput input = inputOf({simulateThickStack(truth, 2, 3)});
  input.outputGrid = truth.geometry;
  Settings settings = defaults(9);
  settings.consistency = true;
  const auto whole = reconstruct(input, settings);
  for (const double radius : {6.0, 11.0}) {
    const Mask mask = ballOf(truth.geometry, radius);
    input.masks = {mask};
    const auto part = reconstruct(input, settings);
    const double inside =
        static_cast<double>(std::count(mask.voxels.begin(), mask.voxels.end(), 1)) / (40 * 38 * 36);
    EXPECT_LT(*part.settings.gaussians, 4 * inside * static_cast<double>(*whole.settings.gaussians) + 30);
    Settings more = settings;
    more.gaussians = *whole.settings.gaussians;
    EXPECT_GT(insidePsnr(part.volume, truth, mask),
              insidePsnr(reconstruct(input, more).volume, truth, mask) - 0.1)
        << "radius " << radius;
  }
}

TEST(JobDensity, ARegionIsAsGoodAsInTheWholeFit) {
  ReconstructionInput input = inputOf({pointStack(head())});
  const Volume& truth = input.stacks.front().image;
  input.outputGrid = truth.geometry;
  for (const double radius : {7.0, 11.0}) {
    Region region;
    const Vec3 centre = truth.geometry.centre();
    for (int a = 0; a < 3; ++a) {
      region.min[a] = centre[a] - radius;
      region.max[a] = centre[a] + radius;
    }
    const Mask box = maskInSpace(truth.geometry, [&](const Vec3& x) {
      const Vec3 d = x - centre;
      return std::max({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])}) < radius;
    });
    ReconstructionInput part = input;
    part.stacks.front() = cropped(input.stacks.front(), region, 2);
    ASSERT_TRUE(part.stacks.front().isRegion);
    const Volume whole = reconstruct(input, defaults()).volume, cut = reconstruct(part, defaults()).volume;
    EXPECT_GT(insidePsnr(cut, truth, box), insidePsnr(whole, truth, box) - 0.3) << radius;
  }
  Region everywhere{{-500, -500, -500}, {500, 500, 500}};
  EXPECT_FALSE(cropped(input.stacks.front(), everywhere).isRegion);
}

TEST(JobDensity, VolumeThatSeveralStacksSeeCountsOnce) {
  std::vector<Stack> stacks(3);
  stacks[0].image = volumeOf(grid(10, 10, 10), [](auto, auto, auto) { return 1; });
  stacks[1].image = volumeOf(grid(10, 10, 5, {1, 1, 2}, {5, 0, 0.5}), [](auto, auto, auto) { return 1; });
  stacks[2].image = volumeOf(grid(4, 4, 4, {1, 1, 1}, {30, 0, 0}), [](auto, auto, auto) { return 1; });
  EXPECT_NEAR(geometryTraits(stacks).volume, 1500 + 64, 1e-6);
  stacks[0].image.voxels[0] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_NEAR(measureTraits(stacks, {}).volume, 1499 + 64, 1e-6);
  EXPECT_NEAR(geometryTraits({stacks.data(), 1}).volume, 1000, 1e-9);
}

namespace {

Mask cubeMask(std::int64_t side) {
  Mask mask{smallGrid(), std::vector<std::uint8_t>(24 * 22 * 20, 0)};
  for (std::int64_t k = 0; k < side; ++k)
    for (std::int64_t j = 0; j < side; ++j)
      for (std::int64_t i = 0; i < side; ++i)
        mask.voxels[10 + i + 24 * (9 + j + 22 * (8 + k))] = 1;
  return mask;
}

} // namespace

TEST(JobDensity, MasksOfAFewVoxelsWork) {
  ReconstructionInput input = isotropicInput();
  for (const int side : {1, 4}) {
    input.masks = {cubeMask(side)};
    input.outputGrid = smallGrid();
    const ReconstructionResult result = reconstruct(input, defaults(60));
    EXPECT_LE(*result.settings.gaussians, side * side * side);
    EXPECT_GT(insidePsnr(result.volume, input.stacks.front().image, input.masks.front()), 40) << side;
  }
}

TEST(JobDensity, AMaskBetweenThickSlicesIsRefusedOrFitted) {
  ReconstructionInput input = anisotropicInput();
  input.masks = {cubeMask(4)};
  EXPECT_GT(reconstruct(input, defaults()).trainingPsnr, 30);
  input.masks = {cubeMask(1)};
  const Error error = test::errorOf([&] { reconstruct(input, defaults()); });
  EXPECT_EQ(error.code(), ErrorCode::NoData) << "it holds no centre of a voxel";
  EXPECT_TRUE(test::contains(error, "smaller than their voxels"));
}
