// Several scans that mostly lie beside each other.
#include "Core/Fit/Plan.h"
#include "Core/Image/CubicConvolution.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"
#include "Core/Job/MemoryEstimate.h"
#include "JobInputs.h"

#include <cmath>

namespace innergs::testing {
namespace {

constexpr std::int64_t kSlices = 20;
const GridGeometry kTruthGrid = grid(48, 44, 4 * kSlices, {1, 1, 1}, {-30, 12, 5}, obliqueDirection(0.3));

Volume tissue() {
  return volumeOf(kTruthGrid, [](float i, float j, float k) {
    return 100 + 40 * std::sin(i / 3.1F) * std::sin(j / 2.9F) * std::sin(k / 3.3F) +
           30 * std::sin((i + k) / 2.7F) + 20 * std::sin(j / 5.F);
  });
}

/// 4 mm slices [first, first + count) of all.
Stack slabOf(const Volume& volume, std::int64_t first, std::int64_t count) {
  const GridGeometry part = cropped(volume.geometry, {0, 0, 4 * first}, {48, 44, 4 * count});
  const auto plane = std::int64_t{48} * 44;
  return simulateThickStack(
      {part,
       {volume.voxels.begin() + 4 * first * plane, volume.voxels.begin() + 4 * (first + count) * plane}},
      2, 4);
}

ReconstructionInput twoSlabs(std::int64_t overlap = 1) {
  const Volume volume = tissue();
  ReconstructionInput input =
      inputOf({slabOf(volume, 0, 10), slabOf(volume, 10 - overlap, kSlices - 10 + overlap)});
  input.stacks[0].name = "upper";
  input.stacks[1].name = "lower";
  input.outputGrid = kTruthGrid;
  return input;
}

Settings still(PredictionKind kind = PredictionKind::Auto) {
  Settings settings = fastSettings();
  settings.align = false;
  settings.sliceMotion = SliceMotionKind::Off;
  settings.prediction = kind;
  return settings;
}

bool predicting(const Progress& p) {
  return p.phase == Phase::Predicting;
}

TEST(AdjoiningScans, LieMostlyBesideEachOther) {
  const Volume volume = tissue();
  const auto adjoin = [](const std::vector<Stack>& stacks) { return geometryTraits(stacks).adjoining; };
  const Stack upper = slabOf(volume, 0, 10), lower = slabOf(volume, 9, 11);
  EXPECT_TRUE(adjoin({upper, lower}));
  EXPECT_TRUE(adjoin({lower, upper}));
  EXPECT_TRUE(adjoin({slabOf(volume, 0, 6), slabOf(volume, 6, 8), slabOf(volume, 13, 7)}));
  EXPECT_FALSE(adjoin({upper}));
  EXPECT_FALSE(adjoin({slabOf(volume, 0, 15), slabOf(volume, 4, 16)})) << "most is seen twice";
  Stack turned = lower;
  turned.image.geometry.direction = obliqueDirection(0.6);
  EXPECT_TRUE(adjoin({upper, turned}));
  EXPECT_FALSE(adjoin(orthogonalInput().stacks));
  Stack posed = lower;
  posed.poses.assign(11, Affine3{});
  EXPECT_FALSE(adjoin({upper, posed}));
  Stack thin = lower;
  thin.image.geometry.spacing[2] = 1.2;
  EXPECT_FALSE(adjoin({upper, thin}));
}

TEST(AdjoiningScans, GiveWhatOneScanGives) {
  ReconstructionInput whole = inputOf({slabOf(tissue(), 0, kSlices)});
  whole.outputGrid = kTruthGrid;
  const double one = psnr(reconstruct(whole, still()).volume, tissue());
  const double none = psnr(reconstruct(twoSlabs(), still(PredictionKind::None)).volume, tissue());
  EXPECT_GT(one, none + 0.5);
  for (const std::int64_t overlap : {0, 1, 3}) {
    const ReconstructionResult result = reconstruct(twoSlabs(overlap), still());
    EXPECT_GT(psnr(result.volume, tissue()), one - 0.4) << overlap << " slices";
    EXPECT_NE(result.prediction.find("upper: Between the slices: "), std::string::npos) << result.prediction;
    EXPECT_NE(result.prediction.find("lower: Between the slices: "), std::string::npos) << result.prediction;
  }
  ReconstructionInput reversed = twoSlabs();
  std::swap(reversed.stacks[0], reversed.stacks[1]);
  EXPECT_GT(psnr(reconstruct(reversed, still()).volume, tissue()), one - 0.4);
}

/// The largest root mean square error of a plane across the slices, relative to the mean of all.
double worstPlane(const Volume& result, const Volume& truth) {
  const auto plane = std::int64_t{48} * 44;
  double worst = 0, sum = 0;
  for (std::int64_t k = 0; k < kTruthGrid.size[2]; ++k) {
    double squares = 0;
    for (std::int64_t v = k * plane; v < (k + 1) * plane; ++v)
      squares += std::pow(static_cast<double>(result.voxels[v]) - truth.voxels[v], 2);
    if (k >= 4 && k < kTruthGrid.size[2] - 4) worst = std::max(worst, squares);
    sum += squares;
  }
  return std::sqrt(worst * static_cast<double>(kTruthGrid.size[2]) / sum);
}

TEST(AdjoiningScans, LeaveNoSeam) {
  ReconstructionInput whole = inputOf({slabOf(tissue(), 0, kSlices)});
  whole.outputGrid = kTruthGrid;
  const double usual = worstPlane(reconstruct(whole, still()).volume, tissue());
  for (const std::int64_t overlap : {0, 2})
    EXPECT_LT(worstPlane(reconstruct(twoSlabs(overlap), still()).volume, tissue()), 1.1 * usual) << overlap;
}

TEST(AdjoiningScans, MayMissASliceBetweenThem) {
  const ReconstructionResult result = reconstruct(twoSlabs(-1), still());
  EXPECT_FALSE(result.prediction.empty());
  for (const float v : result.volume.voxels)
    ASSERT_TRUE(std::isfinite(v));
  const double none = psnr(reconstruct(twoSlabs(-1), still(PredictionKind::None)).volume, tissue());
  EXPECT_GT(psnr(result.volume, tissue()), none);
}

TEST(AdjoiningScans, MayHaveOtherPixelsAndBeTurned) {
  const Volume volume = tissue();
  ReconstructionInput input = twoSlabs();
  Stack& lower = input.stacks[1];
  GridGeometry fine = grid(52, 50, 40, {0.8, 0.8, 1}, {}, obliqueDirection(0.34));
  fine.origin = kTruthGrid.indexToWorld()({4, 3, 38});
  const Affine3 map = inverse(kTruthGrid.indexToWorld());
  Volume seen = volumeInSpace(fine, [&](const Vec3& x) { return cubicAt(volume, map(x)); });
  lower = simulateThickStack(seen, 2, 4);
  ASSERT_TRUE(geometryTraits(input.stacks).adjoining);
  const Volume with = reconstruct(input, still()).volume,
               without = reconstruct(input, still(PredictionKind::None)).volume;
  // Where the turned slab shows all of its tissue.
  const auto error = [&](const Volume& result) {
    double squares = 0;
    std::int64_t v = 0, count = 0;
    for (std::int64_t k = 0; k < kTruthGrid.size[2]; ++k)
      for (std::int64_t j = 0; j < 44; ++j)
        for (std::int64_t i = 0; i < 48; ++i, ++v) {
          const Vec3 x = kTruthGrid.indexToWorld()({double(i), double(j), double(k)});
          if (k > 34 && depthInside(fine, inverse(fine.indexToWorld())(x)) < 5) continue;
          squares += std::pow(static_cast<double>(result.voxels[v]) - volume.voxels[v], 2);
          ++count;
        }
    EXPECT_GT(count, 50'000);
    return std::sqrt(squares / static_cast<double>(count));
  };
  EXPECT_LT(error(with), error(without));
  for (const float v : with.voxels)
    ASSERT_TRUE(std::isfinite(v));
}

// Axial slices of one part, sagittal ones of the other.
TEST(AdjoiningScans, MayHaveSlicesAtRightAngles) {
  const Volume volume = tissue();
  ReconstructionInput input =
      inputOf({slabOf(volume, 0, 11),
               simulateThickStack(cropped(volume, IndexBlock{{0, 0, 40}, {48, 44, 40}}), 0, 4)});
  input.outputGrid = kTruthGrid;
  ASSERT_TRUE(geometryTraits(input.stacks).adjoining);
  EXPECT_GT(psnr(reconstruct(input, still()).volume, volume),
            psnr(reconstruct(input, still(PredictionKind::None)).volume, volume));
}

// Sagittal stations: the second continues the first in plane.
TEST(AdjoiningScans, AreAllInTheResult) {
  const Volume volume = tissue();
  const auto station = [&](std::int64_t first, std::int64_t planes) {
    return simulateThickStack(cropped(volume, IndexBlock{{0, 0, first}, {48, 44, planes}}), 0, 4);
  };
  const ReconstructionInput input = inputOf({station(0, 44), station(36, 44)});
  const GridGeometry all = acquisitionGrid(input.stacks), whole = station(0, 80).image.geometry;
  EXPECT_TRUE(sameGrid(all, whole));
  const Volume result = reconstruct(input, still()).volume;
  const Affine3 map = inverse(kTruthGrid.indexToWorld()) * result.geometry.indexToWorld();
  const auto& n = result.geometry.size;
  EXPECT_EQ(n[0] * n[1] * n[2], kTruthGrid.voxelCount());
  double squares = 0;
  for (std::int64_t v = 0; v < result.geometry.voxelCount(); ++v) {
    const Vec3 at = map({double(v % n[0]), double(v / n[0] % n[1]), double(v / n[0] / n[1])});
    squares += std::pow(static_cast<double>(result.voxels[v]) - cubicAt(volume, at), 2);
  }
  EXPECT_GT(10 * std::log10(200 * 200 * static_cast<double>(kTruthGrid.voxelCount()) / squares), 26);
}

TEST(AdjoiningScans, NeverShowHeldOutSlices) {
  ReconstructionInput input = twoSlabs();
  const std::int64_t plane = std::int64_t{48} * 44;
  holdOut(input.stacks[0], {4, 9});
  holdOut(input.stacks[1], {0, 5});
  const auto before = reconstruct(input, still());
  for (Stack& stack : input.stacks)
    for (std::size_t v = 0; v < stack.observed.size(); ++v)
      if (!stack.observed[v]) stack.image.voxels[v] = static_cast<std::int64_t>(v) / plane % 2 ? 1e5F : -1e5F;
  EXPECT_EQ(before.volume.voxels, reconstruct(input, still()).volume.voxels);
}

TEST(AdjoiningScans, StayInsideTheirMask) {
  ReconstructionInput input = twoSlabs();
  Mask mask{kTruthGrid, std::vector<std::uint8_t>(static_cast<std::size_t>(kTruthGrid.voxelCount()), 0)};
  const auto inside = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return (i - 24) * (i - 24) + (j - 22) * (j - 22) < 300 && k > 14 && k < 66;
  };
  std::size_t v = 0;
  for (std::int64_t k = 0; k < kTruthGrid.size[2]; ++k)
    for (std::int64_t j = 0; j < 44; ++j)
      for (std::int64_t i = 0; i < 48; ++i, ++v)
        mask.voxels[v] = inside(i, j, k);
  input.masks = {mask};
  const ReconstructionResult result = reconstruct(input, still());
  EXPECT_FALSE(result.prediction.empty());
  double squares = 0, count = 0;
  v = 0;
  for (const Volume volume = tissue(); v < volume.voxels.size(); ++v) {
    if (!mask.voxels[v]) continue;
    squares += std::pow(static_cast<double>(result.volume.voxels[v]) - volume.voxels[v], 2);
    ++count;
  }
  EXPECT_GT(10 * std::log10(200 * 200 * count / squares), 28);
}

TEST(AdjoiningScans, AreTheSameWithAnyNumberOfThreads) {
  Settings settings = still();
  settings.threads = 1;
  const auto one = reconstruct(twoSlabs(), settings);
  settings.threads = 3;
  const auto several = reconstruct(twoSlabs(), settings);
  EXPECT_TRUE(sameField(one.model->field, several.model->field));
  EXPECT_EQ(one.volume.voxels, several.volume.voxels);
}

TEST(AdjoiningScans, StopAtOnceAndGoOnToTheSameResult) {
  const Attempt whole = runUntil({}, twoSlabs(), still());
  double before = 0;
  for (const Progress& p : whole.states) {
    EXPECT_GE(p.fraction, before);
    before = p.fraction;
  }
  for (const double share : {0.1, 0.5}) {
    const auto stopped =
        runUntil([&](const Progress& p) { return predicting(p) && p.fraction >= share; }, twoSlabs(), still())
            .result;
    ASSERT_TRUE(stopped.cancelled);
    EXPECT_TRUE(stopped.model->field.gaussians.empty());
  }
  ReconstructionInput again = twoSlabs();
  again.resume = stoppedAt(5, twoSlabs(), still()).model;
  EXPECT_TRUE(sameField(reconstruct(again, still()).model->field, whole.result.model->field));
}

TEST(AdjoiningScans, LeaveOtherFitsAlone) {
  for (const PredictionKind kind : {PredictionKind::None, PredictionKind::Auto}) {
    Settings settings = still(kind);
    if (kind == PredictionKind::Auto) settings.blending = Blending::Additive;
    EXPECT_TRUE(reconstruct(twoSlabs(), settings).prediction.empty());
  }
}

TEST(AdjoiningScans, NeedMemoryForWhatLiesBetweenAllSlices) {
  const ReconstructionInput slabs = twoSlabs();
  ReconstructionInput one = inputOf({slabOf(tissue(), 0, kSlices)});
  one.outputGrid = kTruthGrid;
  EXPECT_GE(estimateMemory(slabs, still()), estimateMemory(one, still()));
}

} // namespace
} // namespace innergs::testing
