#include "Core/Image/Components.h"

#include <gtest/gtest.h>

#include <numeric>

namespace innergs {
namespace {

TEST(Components, KeepsTheLargestOrLargeEnoughParts) {
  // Parts of 3, 2 and 1 voxels along one row; diagonal neighbours are apart.
  const std::vector<std::uint8_t> given{1, 1, 1, 0, 1, 1, 0, 1};
  const std::array<std::int64_t, 3> size{8, 1, 1};
  const auto kept = [&](std::int64_t least, bool largest) {
    std::vector<std::uint8_t> mask = given;
    keepParts(mask, size, least, largest);
    return std::accumulate(mask.begin(), mask.end(), 0);
  };
  EXPECT_EQ(kept(1, false), 6);
  EXPECT_EQ(kept(2, false), 5);
  EXPECT_EQ(kept(0, true), 3);
  EXPECT_EQ(kept(4, true), 0);
  std::vector<std::uint8_t> diagonal{1, 0, 0, 1};
  EXPECT_EQ(floodFill(diagonal, {2, 2, 1}, 0).size(), 1u);
}

} // namespace
} // namespace innergs
