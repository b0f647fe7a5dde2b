#include "Core/Acquisition/BlankSlices.h"
#include "../Alignment/HeadPhantom.h"
#include "../JobInputs.h"
#include "Core/Image/Simulate.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <limits>

namespace innergs {
namespace {

using Slices = std::vector<std::int64_t>;

constexpr std::int64_t kBlankTestWidth = 48;

/// Twenty-four slices of 2 mm.
Stack headScan() {
  Stack scan = simulateThickStack(testing::headPhantom(kBlankTestWidth), 2, 2, 2, 1);
  scan.name = "scan";
  return scan;
}

void fillSlices(Stack& scan, const Slices& slices, float value) {
  const std::int64_t plane = scan.image.geometry.size[0] * scan.image.geometry.size[1];
  for (const std::int64_t k : slices)
    std::fill_n(scan.image.voxels.begin() + k * plane, plane, value);
}

Slices foundIn(const Slices& slices, float value = 0) {
  Stack scan = headScan();
  fillSlices(scan, slices, value);
  return blankSlices(scan);
}

TEST(BlankSlices, LieBetweenSlicesThatShowTheBody) {
  EXPECT_EQ(foundIn({}), Slices());
  EXPECT_EQ(foundIn({12}), Slices{12});
  EXPECT_EQ(foundIn({12}, -1024), Slices{12});
  EXPECT_EQ(foundIn({9, 10}, 70), (Slices{9, 10}));
  EXPECT_EQ(foundIn({12}, std::numeric_limits<float>::quiet_NaN()), Slices()) << "never was observed";
  EXPECT_EQ(foundIn({0, 1}), Slices()) << "beside the body";
  EXPECT_EQ(foundIn({22, 23}), Slices());
  EXPECT_EQ(foundIn({6, 12, 18}), Slices()) << "more than a tenth";
}

TEST(BlankSlices, AreNotThoseBetweenThings) {
  Stack scan = headScan();
  const std::int64_t n = scan.image.geometry.size[0], plane = n * n;
  std::fill(scan.image.voxels.begin(), scan.image.voxels.end(), 0.f);
  for (const std::int64_t k : {5, 6, 7, 9, 10, 11}) // one thing at the left, another at the right
    for (std::int64_t p = 0; p < plane; ++p)
      if ((p % n < n / 2) == (k < 8)) scan.image.voxels[k * plane + p] = 100;
  EXPECT_EQ(blankSlices(scan), Slices());
}

TEST(BlankSlices, AreSaid) {
  EXPECT_EQ(blankSlicesSentence({}, "ax"), "");
  EXPECT_EQ(blankSlicesSentence(Slices{3}, "ax"),
            "Slice 3 of ax is blank between slices that show the body (counted from 0): it was left out.");
  const std::string many = blankSlicesSentence(Slices{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}, "ax");
  EXPECT_NE(many.find("Slices 1, 2, 3, 4, 5, 6, 7, 8, 9, 10 and 2 more of ax are blank"), std::string::npos)
      << many;
}

TEST(BlankSlices, CostAFitNoMoreThanMissingOnesDo) {
  const Volume head = testing::headPhantom(kBlankTestWidth);
  for (const int scans : {1, 2}) {
    const auto fit = [&](float value, bool ignored) {
      ReconstructionInput input;
      for (int s = 0; s < scans; ++s)
        input.stacks.push_back(simulateThickStack(head, 2 - s, 2, 2, static_cast<std::uint64_t>(s) + 1));
      input.stacks[0].name = "scan";
      fillSlices(input.stacks[0], {12}, value);
      input.outputGrid = head.geometry;
      input.heldOutFraction = 0.2;
      Settings settings = testing::fastSettings();
      settings.ignorePadding = ignored;
      settings.sliceMotion = SliceMotionKind::Off;
      return testing::reconstruct(input, settings);
    };
    const auto said = [](const ReconstructionResult& result) {
      return testing::warningsWith(result, "Slice 12 of scan is blank");
    };
    const ReconstructionResult missing = fit(std::numeric_limits<float>::quiet_NaN(), true),
                               left = fit(0, true), used = fit(0, false);
    EXPECT_NEAR(testing::psnr(left.volume, head), testing::psnr(missing.volume, head), 0.5) << scans;
    EXPECT_GT(testing::psnr(left.volume, head), testing::psnr(used.volume, head) + 2) << scans;
    EXPECT_NEAR(left.heldOutPsnr, missing.heldOutPsnr, 0.5) << "nor is it judged by";
    EXPECT_EQ(said(left), 1);
    EXPECT_EQ(said(used), 0);
  }
}

} // namespace
} // namespace innergs
