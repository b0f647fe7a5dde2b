#include "Core/Acquisition/SliceOrder.h"

#include <gtest/gtest.h>

#include <vector>

namespace innergs::test {
namespace {

int passes(const std::vector<double>& times) {
  return interleavedPasses(times);
}

TEST(SliceOrder, FindsTheFewestPasses) {
  EXPECT_EQ(passes({0, 1, 2, 3}), 1);
  EXPECT_EQ(passes({9, 6, 3, 0}), 1);
  EXPECT_EQ(passes({0, 3, 1, 4, 2}), 2);          // even slices first
  EXPECT_EQ(passes({3, 0, 4, 1, 5, 2}), 2);       // odd slices first
  EXPECT_EQ(passes({5, 2, 4, 1, 3, 0}), 2);       // from the last one on
  EXPECT_EQ(passes({0, 2, 4, 1, 3, 5}), 3);       // 0, 3, 1, 4, 2, 5
  EXPECT_EQ(passes({0, 2, 1, 3, 0, 2, 1, 3}), 2); // two slices at a time
  EXPECT_EQ(passes({0, 1, 2, 0, 1, 2}), 3);       // likewise: k and k + 3 together
}

TEST(SliceOrder, KnowsNoPassesElsewhere) {
  EXPECT_EQ(passes({}), 0);
  EXPECT_EQ(passes({1}), 0);
  EXPECT_EQ(passes({2, 2, 2, 2}), 0);
  EXPECT_EQ(passes({0, 3, 2, 1, 5, 4}), 0);
  EXPECT_EQ(passes({0, 2, 1}), 0); // a pass of one slice
  EXPECT_EQ(sliceOrderText(std::vector<double>{}), "");
  EXPECT_EQ(sliceOrderText(std::vector<double>{0, 3, 2, 1, 5, 4}), "in another order");
  EXPECT_EQ(sliceOrderText(std::vector<double>{0, 2, 1, 3}), "in 2 interleaved passes");
}

} // namespace
} // namespace innergs::test
