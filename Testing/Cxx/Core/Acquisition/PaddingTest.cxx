// Several scans of which one was filled up, as by resampling it to another grid.
#include "Core/Acquisition/Padding.h"
#include "../Alignment/HeadPhantom.h"
#include "../JobInputs.h"
#include "Core/Image/Simulate.h"

#include <algorithm>
#include <numeric>

namespace innergs {
namespace {

using testing::psnr;
using testing::reconstruct;
using Marks = std::vector<std::uint8_t>;

constexpr std::int64_t kWidth = 48;
constexpr double kMargin = 8; // mm

/// Three scans of the head at right angles.
std::vector<Stack> headScans() {
  const Volume head = testing::headPhantom(kWidth);
  std::vector<Stack> scans;
  for (int axis = 0; axis < 3; ++axis) {
    scans.push_back(simulateThickStack(head, axis, 4, 2, static_cast<std::uint64_t>(axis) + 1));
    scans.back().name = "scan" + std::to_string(axis);
  }
  return scans;
}

/// Which voxels of a scan lie beyond the middle of its first axis.
Marks half(const Stack& scan) {
  Marks marks(scan.image.voxels.size());
  const std::int64_t n = scan.image.geometry.size[0];
  for (std::int64_t v = 0; v < static_cast<std::int64_t>(marks.size()); ++v)
    marks[static_cast<std::size_t>(v)] = v % n >= n / 2;
  return marks;
}

void fillHalf(Stack& scan, float value) {
  const Marks marks = half(scan);
  for (std::size_t v = 0; v < marks.size(); ++v)
    if (marks[v]) scan.image.voxels[v] = value;
}

std::vector<Marks> paddingOf(std::span<const Stack> scans, const std::vector<Affine3>& places,
                             double margin) {
  ThreadPool pool(2);
  std::vector<std::size_t> all(scans.size());
  std::iota(all.begin(), all.end(), 0);
  return paddedVoxels(scans, all, places, margin, pool);
}
std::vector<Marks> paddingOf(std::span<const Stack> scans, double margin = kMargin) {
  return paddingOf(scans, std::vector<Affine3>(scans.size()), margin);
}

bool empty(const Marks& marks) {
  return std::find(marks.begin(), marks.end(), 1) == marks.end();
}

TEST(Padding, IsFoundWithTheVoxelsNextToIt) {
  std::vector<Stack> scans = headScans();
  fillHalf(scans[1], 0);
  const std::vector<Marks> padded = paddingOf(scans);
  EXPECT_TRUE(empty(padded[0]));
  EXPECT_TRUE(empty(padded[2]));
  const std::int64_t n = scans[1].image.geometry.size[0];
  ASSERT_EQ(padded[1].size(), scans[1].image.voxels.size());
  for (std::int64_t v = 0; v < static_cast<std::int64_t>(padded[1].size()); ++v)
    ASSERT_EQ(padded[1][static_cast<std::size_t>(v)], v % n >= n / 2 - 1) << v;
  EXPECT_NE(paddingSentence(padded[1], "scan1").find("% of the voxels of scan1 look like padding"),
            std::string::npos);
  EXPECT_EQ(paddingSentence(padded[0], "scan0"), "");
}

TEST(Padding, MayHaveAnyValue) {
  for (const float value : {-1000.F, 50.F, 4000.F}) {
    std::vector<Stack> scans = headScans();
    fillHalf(scans[2], value);
    EXPECT_FALSE(empty(paddingOf(scans)[2])) << value;
  }
}

/// The same in air without noise.
std::vector<Stack> scansInCleanAir() {
  std::vector<Stack> scans = headScans();
  for (Stack& scan : scans)
    for (float& v : scan.image.voxels)
      if (v < 10) v = 0;
  return scans;
}

TEST(Padding, IsNoCleanAir) {
  for (const Marks& marks : paddingOf(scansInCleanAir()))
    EXPECT_TRUE(empty(marks));
}

TEST(Padding, IsNoEvenTissue) {
  const Volume balls = testing::spherePhantom(kWidth, kWidth, 3); // in tissue of one value
  const std::vector<Stack> scans{simulateThickStack(balls, 2, 4), simulateThickStack(balls, 0, 4)};
  for (const Marks& marks : paddingOf(scans))
    EXPECT_TRUE(empty(marks));
}

TEST(Padding, StaysWhereNoOtherScanAcquiredAnything) {
  std::vector<Stack> scans = headScans();
  for (Stack& scan : scans)
    fillHalf(scan, 0);
  // The first axes of the scans differ, so in one octant all are filled.
  const std::vector<Marks> padded = paddingOf(scans, 4);
  std::vector<Marks> filled;
  for (const Stack& scan : scans)
    filled.push_back(half(scan));
  for (std::size_t s = 0; s < scans.size(); ++s) {
    ASSERT_FALSE(padded[s].empty());
    std::int64_t left = 0;
    for (std::size_t v = 0; v < filled[s].size(); ++v)
      left += filled[s][v] && !padded[s][v];
    EXPECT_NEAR(static_cast<double>(left) / static_cast<double>(filled[s].size()), 0.25, 0.03) << s;
  }
}

TEST(Padding, OfAScanIsJudgedWhereItLies) {
  std::vector<Stack> scans = scansInCleanAir();
  scans[0].image.geometry.origin[1] += 24;
  EXPECT_FALSE(empty(paddingOf(scans, 4)[0])) << "the others' head lies in its air";
  std::vector<Affine3> places(3);
  places[0].offset = {0, -24, 0};
  EXPECT_TRUE(empty(paddingOf(scans, places, 4)[0]));
}

TEST(Padding, OfASingleScanAndOfSlicesWithPosesIsLeft) {
  std::vector<Stack> scans = headScans();
  fillHalf(scans[1], 0);
  EXPECT_TRUE(empty(paddingOf(std::span(&scans[1], 1))[0]));
  scans[1].poses.assign(static_cast<std::size_t>(scans[1].image.geometry.size[2]), {});
  EXPECT_TRUE(empty(paddingOf(scans)[1]));
}

TEST(Padding, CostsAFitNoMoreThanMissingVoxelsDo) {
  const Volume head = testing::headPhantom(kWidth);
  const auto fit = [&](float value, bool ignored, double shift) {
    ReconstructionInput input = testing::inputOf(headScans());
    fillHalf(input.stacks[1], value);
    input.stacks[1].image.geometry.origin[2] += shift;
    input.outputGrid = head.geometry;
    input.heldOutFraction = 0.2;
    Settings settings = testing::fastSettings();
    settings.ignorePadding = ignored;
    settings.sliceMotion = SliceMotionKind::Off;
    return reconstruct(input, settings);
  };
  const auto said = [](const ReconstructionResult& result) {
    return testing::warningsWith(result, "scan1 look like padding");
  };
  const ReconstructionResult missing = fit(std::numeric_limits<float>::quiet_NaN(), true, 0),
                             ignored = fit(0, true, 0), used = fit(0, false, 0), moved = fit(0, true, 3);
  EXPECT_GT(psnr(ignored.volume, head), psnr(missing.volume, head) - 0.5);
  EXPECT_GT(psnr(ignored.volume, head), psnr(used.volume, head) + 3);
  EXPECT_GT(psnr(moved.volume, head), psnr(missing.volume, head) - 1.5) << "aligned without it";
  EXPECT_NEAR(ignored.heldOutPsnr, missing.heldOutPsnr, 0.5) << "nor is it judged by";
  EXPECT_EQ(said(ignored), 1);
  EXPECT_EQ(said(moved), 1);
  EXPECT_EQ(said(used), 0);
}

TEST(Padding, IsNotWhatScansThatLieApartShow) {
  ReconstructionInput input = testing::inputOf(scansInCleanAir());
  input.stacks[2].image.geometry.origin[0] += 14;
  Settings settings = testing::quickSettings();
  settings.sliceMotion = SliceMotionKind::Off;
  const ReconstructionResult result = reconstruct(input, settings);
  ASSERT_EQ(result.alignment.size(), 3u);
  EXPECT_NEAR(result.alignment[2].toOthers.offset[0], -14, 0.5);
  for (const std::string& sentence : result.warnings)
    EXPECT_EQ(sentence.find("padding"), std::string::npos) << sentence;
}

} // namespace
} // namespace innergs
