#include "Core/Acquisition/InterleaveGain.h"
#include "../Alignment/HeadPhantom.h"
#include "../JobInputs.h"
#include "Core/Image/Simulate.h"

#include <algorithm>
#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr std::int64_t kInterleavedWidth = 56;

/// Fourteen slices of 4 mm, the odd ones brighter by `gain`.
Stack interleavedScan(double gain, int axis = 2, double noise = 2) {
  Stack scan = simulateThickStack(testing::headPhantom(kInterleavedWidth), axis, 4, noise, 3);
  for (float& v : scan.image.voxels)
    v = std::max(v, 0.f);
  scan.name = "scan" + std::to_string(axis);
  evenOutInterleaves(1 / gain, scan);
  return scan;
}

TEST(InterleaveGain, IsFoundWhereEverySecondSliceIsBrighter) {
  ThreadPool pool(2);
  for (const double gain : {0.9, 0.95, 1.05, 1.1, 1.3})
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(interleaveGain(interleavedScan(gain, axis), pool), gain, 0.01) << axis;
  for (int axis = 0; axis < 3; ++axis)
    for (const double noise : {0, 2, 20})
      EXPECT_EQ(interleaveGain(interleavedScan(1, axis, noise), pool), 1) << axis << " " << noise;
}

TEST(InterleaveGain, IsRemovedAroundTheMean) {
  Stack scan = interleavedScan(1);
  const std::vector<float> before = scan.image.voxels;
  evenOutInterleaves(1.21, scan);
  const std::int64_t plane = kInterleavedWidth * kInterleavedWidth;
  for (std::int64_t v = 4 * plane; v < 6 * plane; ++v)
    ASSERT_NEAR(scan.image.voxels[v], before[v] * (v < 5 * plane ? 1.1f : 1 / 1.1f), 1e-4f * before[v]);
}

TEST(InterleaveGain, IsNotSeenInWhatCannotShowIt) {
  ThreadPool pool(2);
  Stack negative = interleavedScan(1.1);
  negative.image.voxels[0] = -1;
  EXPECT_EQ(interleaveGain(negative, pool), 1);
  Stack posed = interleavedScan(1.1);
  posed.poses.resize(static_cast<std::size_t>(posed.image.geometry.size[2]));
  EXPECT_EQ(interleaveGain(posed, pool), 1);
  Stack few = interleavedScan(1.1);
  few.image.geometry.size[2] = 9;
  few.image.voxels.resize(9 * kInterleavedWidth * kInterleavedWidth);
  EXPECT_EQ(interleaveGain(few, pool), 1);
  Stack one = interleavedScan(1);
  const std::int64_t plane = kInterleavedWidth * kInterleavedWidth;
  std::for_each_n(one.image.voxels.begin() + 7 * plane, plane, [](float& v) { v *= 2; });
  EXPECT_EQ(interleaveGain(one, pool), 1) << "a single bright slice";
}

TEST(InterleaveGain, IsJudgedByObservedVoxelsAlone) {
  ThreadPool pool(2);
  Stack scan = interleavedScan(1.1);
  const double all = interleaveGain(scan, pool);
  scan.observed.assign(scan.image.voxels.size(), 1);
  for (std::size_t v = 0; v < scan.image.voxels.size(); v += 4) {
    scan.observed[v] = 0;
    scan.image.voxels[v] = 1e6f;
  }
  EXPECT_NEAR(interleaveGain(scan, pool), all, 0.01);
  std::fill(scan.observed.begin(), scan.observed.end(), 0);
  EXPECT_EQ(interleaveGain(scan, pool), 1);
}

TEST(InterleaveGain, IsSaidAndCostsAFitNothing) {
  EXPECT_EQ(interleaveGainSentence(1, "ax"), "");
  for (const double gain : {1.05, 1 / 1.05})
    EXPECT_EQ(interleaveGainSentence(gain, "ax"),
              "Every second slice of ax is 5.0 % brighter than those beside it, as where slices are acquired "
              "in two passes: they were made equally bright.");
  const Volume head = testing::headPhantom(kInterleavedWidth);
  for (const int scans : {1, 2}) {
    const auto fit = [&](double gain, bool even) {
      ReconstructionInput input;
      for (int s = 0; s < scans; ++s)
        input.stacks.push_back(interleavedScan(gain, 2 - s));
      input.outputGrid = head.geometry;
      input.heldOutFraction = 0.2;
      Settings settings = testing::fastSettings();
      settings.evenInterleaves = even;
      settings.sliceMotion = SliceMotionKind::Off;
      return testing::reconstruct(input, settings);
    };
    const auto said = [](const ReconstructionResult& result) {
      return testing::warningsWith(result, "Every second slice of scan");
    };
    const ReconstructionResult clean = fit(1, true), even = fit(1.1, true), uneven = fit(1.1, false);
    EXPECT_NEAR(testing::psnr(even.volume, head), testing::psnr(clean.volume, head), 0.3) << scans;
    EXPECT_GT(testing::psnr(even.volume, head), testing::psnr(uneven.volume, head) + 0.5) << scans;
    EXPECT_NEAR(even.heldOutPsnr, clean.heldOutPsnr, 0.5) << scans;
    EXPECT_EQ(said(clean), 0);
    EXPECT_EQ(said(even), scans);
    EXPECT_EQ(said(uneven), 0);
  }
}

} // namespace
} // namespace innergs
