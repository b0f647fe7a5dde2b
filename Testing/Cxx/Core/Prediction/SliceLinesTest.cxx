#include "Core/Prediction/SliceLines.h"

#include "Core/Base/Random.h"
#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs::testing {
namespace {

const GridGeometry kStack = grid(40, 30, 12, {1, 1, 4});
const std::vector<std::uint8_t> kEverywhere(40 * 30 * 12, 1);

SliceLines across(const Volume& v, const std::vector<std::uint8_t>& inside = kEverywhere) {
  return linesAt(voxelsAcross(v.geometry), v.geometry.size[2], v.voxels, inside);
}

TEST(SliceLines, HoldTheSamplesAlongAnAxis) {
  const Volume v = volumeOf(kStack, [](auto i, auto j, auto k) { return i + 100.0 * j + 10000.0 * k; });
  const SliceLines slices = across(v);
  ASSERT_EQ(slices.length, 12);
  ASSERT_EQ(slices.width, 40 * 30);
  for (std::int64_t k = 0; k + 1 < 12; ++k)
    EXPECT_EQ(slices.value[(k + 1) * 1200 + 7] - slices.value[k * 1200 + 7], 10000);
  for (const int axis : {0, 1}) {
    const std::int64_t length = kStack.size[axis];
    const SliceLines lines = linesAt(voxelsWithin(kStack, axis), length, v.voxels, kEverywhere);
    ASSERT_EQ(lines.length, length);
    ASSERT_EQ(static_cast<std::int64_t>(lines.value.size()), length * lines.width);
    for (std::int64_t n = 0; n + 1 < length; ++n)
      EXPECT_EQ(lines.value[(n + 1) * lines.width] - lines.value[n * lines.width], axis == 0 ? 1 : 100);
  }
}

TEST(SliceLines, HoldSecondDifferencesInTheirPlaceWhereAllThreeVoxelsCount) {
  const Volume v = volumeOf(kStack, [](auto i, auto j, auto k) { return 3.0 * i * i + 5.0 * j + 7.0 * k; });
  std::vector<std::uint8_t> inside = kEverywhere;
  inside[20] = 0;
  const auto detail = [&](int axis) {
    return detailAt(voxelsAcross(kStack), 12, kStack, v.voxels, inside, axis);
  };
  const SliceLines first = detail(0), second = detail(1);
  for (std::int64_t i = 0; i < 40; ++i) {
    const bool known = i > 0 && i < 39 && i != 19 && i != 20 && i != 21;
    EXPECT_EQ(first.inside[i], known) << i;
    if (known) EXPECT_EQ(first.value[i], 6) << i;
  }
  EXPECT_EQ(second.inside[5], 0) << "at the border";
  EXPECT_EQ(second.inside[45], 1);
  EXPECT_NEAR(second.value[45], 0, 1e-3);
}

TEST(SliceLines, ChangeAsMuchAsTheyAreUncorrelated) {
  Random random(3);
  Volume noise = volumeOf(kStack, [&](auto, auto, auto) { return random.uniform() - 0.5; });
  EXPECT_NEAR(changeShare(across(noise)), 1, 0.03);
  const Volume same = volumeOf(kStack, [](auto i, auto j, auto) { return std::sin(i + 2.0 * j); });
  EXPECT_NEAR(changeShare(across(same)), 0, 1e-9);
  // The mean of two neighbours has half of its variance in common with the next.
  Volume half = noise;
  for (std::size_t v = 0; v + 1200 < half.voxels.size(); ++v)
    half.voxels[v] = noise.voxels[v] + noise.voxels[v + 1200];
  EXPECT_NEAR(changeShare(across(half)), 0.5, 0.05);
}

TEST(SliceLines, SayNothingOfFewSamples) {
  const Volume v = volumeOf(kStack, [](auto i, auto j, auto k) { return std::sin(i + 2.0 * j + 3.0 * k); });
  std::vector<std::uint8_t> few(kEverywhere.size(), 0);
  for (std::size_t n = 0; n < few.size(); n += 101)
    few[n] = 1;
  EXPECT_EQ(changeShare(across(v, few)), 0);
  EXPECT_EQ(slopeShare(across(v, few)), 0);
  EXPECT_GT(changeShare(across(v)), 0.1);
  EXPECT_GT(slopeShare(across(v)), 0.1);
}

TEST(SliceLines, SlopeWhereChangesAreGradual) {
  const auto edges = [](double width) {
    return volumeOf(grid(40, 30, 40), [=](auto i, auto j, auto k) {
      return std::tanh((std::sin(0.7 * i) * 4 + std::sin(0.9 * j) * 4 + k - 20) / width);
    });
  };
  const std::vector<std::uint8_t> all(40 * 30 * 40, 1);
  EXPECT_GT(slopeShare(across(edges(4), all)), 0.9);
  EXPECT_LT(slopeShare(across(edges(0.1), all)), 0.5);
}

} // namespace
} // namespace innergs::testing
