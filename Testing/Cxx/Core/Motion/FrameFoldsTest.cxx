#include "Core/Motion/FrameFolds.h"

#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

TEST(FrameFolds, HoldOutEveryInnerFrameOnceAndNeverTheEnds) {
  for (const std::size_t frames : {3, 4, 9, 22}) {
    std::vector<double> times;
    for (std::size_t f = 0; f < frames; ++f)
      times.push_back(0.5 * static_cast<double>(f * f));
    std::vector<int> heldOut(frames, 0);
    for (const FrameFold& fold : frameFolds(times)) {
      EXPECT_EQ(fold.kept.size() + fold.heldOut.size(), frames);
      EXPECT_EQ(fold.kept.front(), 0);
      EXPECT_EQ(fold.kept.back(), static_cast<std::int64_t>(frames) - 1);
      for (std::size_t n = 0; n < fold.heldOut.size(); ++n) {
        ++heldOut[fold.heldOut[n]];
        EXPECT_EQ(fold.heldOutTimes[n], times[fold.heldOut[n]]);
      }
      for (std::size_t n = 0; n < fold.kept.size(); ++n)
        EXPECT_EQ(fold.keptTimes[n], times[fold.kept[n]]);
    }
    std::vector<int> expected(frames, 1);
    expected.front() = expected.back() = 0;
    EXPECT_EQ(heldOut, expected) << frames << " frames";
  }
}

TEST(FrameFolds, OfTwoFramesThereAreNone) {
  EXPECT_TRUE(frameFolds({0, 1}).empty());
}

} // namespace
} // namespace innergs::testing
