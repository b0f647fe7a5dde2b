#include "Core/Prediction/MissingSlices.h"

#include "TestVolumes.h"

#include <array>
#include <cmath>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

constexpr std::int64_t kSlice = std::int64_t{12} * 10;

Stack steppedScan() {
  Stack stack;
  stack.image = volumeOf(grid(12, 10, 9, {1, 1, 4}, {-30, 12, 5}, obliqueDirection(0.3)),
                         [](float i, float j, float k) { return 100 + 5 * i - 3 * j + 10 * k; });
  stack.observed.assign(stack.image.voxels.size(), 1);
  return stack;
}

void hide(Stack& stack, std::int64_t slice, std::int64_t count = kSlice) {
  std::fill_n(stack.observed.begin() + slice * kSlice, count, std::uint8_t{0});
  std::fill_n(stack.image.voxels.begin() + slice * kSlice, count, 1e5F);
}

TEST(MissingSlices, LieBetweenTwoOthers) {
  Stack stack = steppedScan();
  for (const int parity : {0, 1})
    EXPECT_TRUE(missingVoxels(stack, parity).empty());
  hide(stack, 0);
  hide(stack, 3, 7);
  hide(stack, 6);
  hide(stack, 8);
  const std::vector<std::size_t> even = missingVoxels(stack, 0), odd = missingVoxels(stack, 1);
  ASSERT_EQ(even.size(), static_cast<std::size_t>(kSlice));
  EXPECT_EQ(even.front(), static_cast<std::size_t>(6 * kSlice));
  ASSERT_EQ(odd.size(), 7U);
  EXPECT_EQ(odd.front(), static_cast<std::size_t>(3 * kSlice));
  stack.observed[5 * kSlice + 1] = 0;
  EXPECT_EQ(missingVoxels(stack, 0).size(), even.size() - 1) << "its neighbour is missing as well";
  hide(stack, 5);
  EXPECT_TRUE(missingVoxels(stack, 0).empty()) << "two in a row";
  Stack few = steppedScan();
  hide(few, 4, 4);
  EXPECT_TRUE(missingVoxels(few, 0).empty()) << "not worth it";
  stack.observed.clear();
  EXPECT_TRUE(missingVoxels(stack, 1).empty());
}

TEST(MissingSlices, AreInterpolatedWithoutTheirValues) {
  Stack stack = steppedScan();
  const Stack whole = stack;
  hide(stack, 0);
  hide(stack, 3);
  hide(stack, 6, 20);
  ThreadPool pool(2);
  const Stack filled =
      withInterpolated(stack, std::array{missingVoxels(stack, 0), missingVoxels(stack, 1)}, pool);
  for (std::int64_t v = 0; v < 9 * kSlice; ++v) {
    EXPECT_EQ(filled.observed[v], v >= kSlice);
    if (v >= kSlice) {
      ASSERT_NEAR(filled.image.voxels[v], whole.image.voxels[v], 1e-3);
    }
  }
}

TEST(MissingSlices, AreThoseThatAreNotFiniteToo) {
  Stack stack = steppedScan();
  const Stack whole = stack;
  stack.observed.clear();
  std::fill_n(stack.image.voxels.begin() + 4 * kSlice, kSlice, std::nanf(""));
  stack.image.voxels[0] = std::nanf("");
  EXPECT_EQ(missingVoxels(stack, 0).size(), static_cast<std::size_t>(kSlice));
  ThreadPool pool(2);
  const Stack filled =
      withInterpolated(stack, std::array{missingVoxels(stack, 0), missingVoxels(stack, 1)}, pool);
  EXPECT_NEAR(filled.image.voxels[4 * kSlice + 3], whole.image.voxels[4 * kSlice + 3], 1e-3);
  EXPECT_TRUE(std::isnan(filled.image.voxels[0]));
  EXPECT_TRUE(filled.observed.empty());
}

TEST(MissingSlices, TheRestOfAScanKeepsItsPlace) {
  const Stack stack = steppedScan(), rest = fromSlice(stack, 1);
  EXPECT_EQ(rest.image.geometry.size[2], 8);
  EXPECT_LT(norm(rest.image.geometry.origin - stack.image.geometry.indexToWorld()({0, 0, 1})), 1e-9);
  EXPECT_EQ(rest.image.voxels.size(), static_cast<std::size_t>(8 * kSlice));
  EXPECT_EQ(rest.image.voxels.front(), stack.image.voxels[kSlice]);
  EXPECT_EQ(rest.observed.size(), rest.image.voxels.size());
}

TEST(MissingSlices, AreJudgedByOddSlicesThatNeverMeet) {
  EXPECT_EQ(probeSlices(steppedScan()), (std::vector<std::int64_t>{1, 5}));
}

} // namespace
} // namespace innergs::testing
