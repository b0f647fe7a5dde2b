// Several scans whose pixels are not points, or were interpolated by the scanner.
#include "Core/Job/ScansAsAcquired.h"
#include "Alignment/HeadPhantom.h"
#include "Core/Acquisition/InterpolatedPixels.h"
#include "Core/Job/JobInput.h"
#include "JobInputs.h"
#include "ThrownError.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

using testing::psnr;
using testing::reconstruct;

constexpr std::int64_t kHeadWidth = 48;

/// Three scans of the head at right angles, zero-filled to half their pixels' size.
ReconstructionInput interpolatedScans(double noise) {
  const Volume head = testing::headPhantom(kHeadWidth);
  ReconstructionInput input;
  ThreadPool pool(1);
  for (int axis = 0; axis < 3; ++axis) {
    input.stacks.push_back(withLargerPixels(
        simulateThickStack(head, axis, 4, noise, static_cast<std::uint64_t>(axis) + 1), {0.5, 0.5}, pool));
    input.stacks.back().name = "scan" + std::to_string(axis);
  }
  return input;
}

Settings still() {
  Settings settings = testing::fastSettings();
  settings.align = false;
  settings.sliceMotion = SliceMotionKind::Off;
  return settings;
}

TEST(ScansAsAcquired, AreBetterThanInterpolatedOnes) {
  const Volume head = testing::headPhantom(kHeadWidth);
  ReconstructionInput input = interpolatedScans(12);
  input.outputGrid = head.geometry;
  Settings settings = still();
  const ReconstructionResult acquired = reconstruct(input, settings);
  settings.acquiredPixels = false;
  const ReconstructionResult stored = reconstruct(input, settings);
  EXPECT_GT(psnr(acquired.volume, head), psnr(stored.volume, head) + 1);
  const auto said = [](const ReconstructionResult& result) {
    return testing::warningsWith(result, "interpolated");
  };
  EXPECT_EQ(said(acquired), 3);
  EXPECT_EQ(said(stored), 0);
}

TEST(ScansAsAcquired, KeepTheOutputGridAndTheJobsInput) {
  ReconstructionInput input = interpolatedScans(12);
  const GridGeometry usual = defaultOutputGrid(input.stacks);
  ReconstructionJob job(input, still());
  const ReconstructionResult result = job.run();
  EXPECT_EQ(result.volume.geometry, usual);
  const ReconstructionInput after = job.takeInput();
  ASSERT_EQ(after.stacks.size(), input.stacks.size());
  for (std::size_t s = 0; s < after.stacks.size(); ++s) {
    EXPECT_EQ(after.stacks[s].image.voxels, input.stacks[s].image.voxels);
    EXPECT_EQ(after.stacks[s].image.geometry, input.stacks[s].image.geometry);
    EXPECT_EQ(after.stacks[s].pixelWidth, 0);
    EXPECT_TRUE(after.stacks[s].remarks.empty());
  }
  EXPECT_FALSE(after.outputGrid);
  EXPECT_FALSE(after.cropToMask);
}

TEST(ScansAsAcquired, ASingleOneIsBetterToo) {
  const Volume head = testing::headPhantom(kHeadWidth);
  ReconstructionInput input = interpolatedScans(12);
  input.stacks.erase(input.stacks.begin(), input.stacks.begin() + 2); // the axial one stays
  input.outputGrid = head.geometry;
  Settings settings = still();
  const double acquired = psnr(reconstruct(input, settings).volume, head);
  settings.acquiredPixels = false;
  EXPECT_GT(acquired, psnr(reconstruct(input, settings).volume, head) + 0.5);
}

TEST(ScansAsAcquired, StayWithThePaperAndWithPoses) {
  ThreadPool pool(1);
  Settings paper = still();
  paper.preset = Preset::Paper;
  ReconstructionInput input = interpolatedScans(12);
  const GridGeometry stored = input.stacks.front().image.geometry;
  {
    const ScansAsAcquired acquired(input, paper, pool);
    EXPECT_EQ(input.stacks.front().image.geometry, stored);
  }
  {
    const ScansAsAcquired acquired(input, still(), pool);
    EXPECT_NE(input.stacks.front().image.geometry, stored);
  }
  input.stacks[1].poses.assign(static_cast<std::size_t>(input.stacks[1].image.geometry.size[2]), {});
  const ScansAsAcquired acquired(input, still(), pool);
  EXPECT_EQ(input.stacks.front().image.geometry, stored);
}

TEST(ScansAsAcquired, WithPixelsOfDifferentSizesAverageOverThem) {
  const Volume head = testing::headPhantom(kHeadWidth);
  std::vector<Stack> scans;
  ThreadPool pool(1);
  for (int axis = 0; axis < 3; ++axis)
    scans.push_back(simulateThickStack(head, axis, 4, 0, 1));
  scans[2] = withLargerPixels(scans[2], {2, 2}, pool);
  Settings settings = still();
  EXPECT_EQ(pixelWidth(scans[0], scans, settings), 0);
  EXPECT_EQ(pixelWidth(scans[2], scans, settings), scans[2].image.geometry.spacing[0]);
  EXPECT_EQ(pixelWidth(scans[2], std::span(&scans[2], 1), settings), 0) << "a single scan's are as they are";
  settings.pixelWidth = 0;
  EXPECT_EQ(pixelWidth(scans[2], scans, settings), 0);
  settings.pixelWidth = 1.5;
  EXPECT_EQ(pixelWidth(scans[0], scans, settings), 1.5);
}

TEST(ScansAsAcquired, RefusePixelsThatAverageOverFarMore) {
  ReconstructionInput input = interpolatedScans(0);
  Settings settings = still();
  settings.pixelWidth = 100;
  const Error error = test::errorOf([&] { reconstruct(input, settings); });
  EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
  EXPECT_NE(std::string(error.what()).find("average over a width of 100 mm"), std::string::npos)
      << error.what();
}

/// Three scans of the head, the last two with pixels of 2 voxels.
ReconstructionInput mixedPixels(const Volume& head) {
  ReconstructionInput input;
  input.outputGrid = head.geometry;
  for (int axis = 0; axis < 3; ++axis) {
    Stack scan = simulateThickStack(head, axis, 4, 0, 1);
    if (axis > 0) { // each pixel is the mean of four
      const Volume from = scan.image;
      const auto& n = from.geometry.size;
      GridGeometry& g = scan.image.geometry;
      g.origin = g.indexToWorld()({0.5, 0.5, 0});
      for (int a = 0; a < 2; ++a) {
        g.size[a] = n[a] / 2;
        g.spacing[a] *= 2;
      }
      scan.image.voxels.clear();
      for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
        const std::int64_t i = 2 * (v % g.size[0]), j = 2 * (v / g.size[0] % g.size[1]),
                           k = v / (g.size[0] * g.size[1]);
        float sum = 0;
        for (int p = 0; p < 4; ++p)
          sum += from.voxels[static_cast<std::size_t>(i + p % 2 + n[0] * (j + p / 2 + n[1] * k))];
        scan.image.voxels.push_back(sum / 4);
      }
    }
    input.stacks.push_back(std::move(scan));
  }
  return input;
}

TEST(ScansAsAcquired, AreSharperIfTheirPixelsAverage) {
  const Volume head = testing::headPhantom(kHeadWidth);
  const ReconstructionInput input = mixedPixels(head);
  Settings settings = still();
  const double averaged = psnr(reconstruct(input, settings).volume, head);
  settings.pixelWidth = 0;
  const double points = psnr(reconstruct(input, settings).volume, head);
  EXPECT_GT(averaged, points + 0.2);
}

} // namespace
} // namespace innergs
