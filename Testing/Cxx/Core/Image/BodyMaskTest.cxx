#include "Core/Image/BodyMask.h"
#include "Core/Image/Metrics.h"
#include "Core/Image/Otsu.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

TEST(BodyMask, OtsuSeparatesTwoClasses) {
  std::vector<float> values(1000, 10);
  for (int p = 0; p < 300; ++p)
    values[p] = 90;
  const double threshold = otsuThreshold(values);
  EXPECT_GT(threshold, 10);
  EXPECT_LT(threshold, 90);
  EXPECT_EQ(otsuThreshold(std::vector<float>(10, 4)), 4);
}

TEST(BodyMask, KeepsTheLargestBodyAndFillsItsHoles) {
  const Volume v = volumeOf(grid(40, 40, 20), [](auto i, auto j, auto k) {
    const double r = std::hypot(i - 20.0, j - 20.0);
    if (k >= 2 && k < 18 && r < 12) return r < 4 ? 0.0 : 100.0; // a tube along K
    if (i < 3 && j < 3 && k < 3) return 100.0;                  // something apart
    return 0.0;
  });
  const auto mask = bodyMask(v);
  for (std::int64_t k = 0; k < 20; ++k)
    for (std::int64_t j = 0; j < 40; ++j)
      for (std::int64_t i = 0; i < 40; ++i) {
        const bool body = k >= 2 && k < 18 && std::hypot(i - 20.0, j - 20.0) < 12;
        ASSERT_EQ(mask[static_cast<std::size_t>(i + 40 * (j + 40 * k))] != 0, body)
            << i << " " << j << " " << k;
      }
}

TEST(BodyMask, ForegroundIsNotAFewBrightVoxels) {
  std::vector<float> values(10000, 0);
  for (int p = 0; p < 4000; ++p)
    values[p] = 100 + static_cast<float>(p % 20);
  EXPECT_EQ(foregroundThreshold(values), otsuThreshold(values));
  for (int p = 0; p < 50; ++p)
    values[p] = 9000;
  EXPECT_GT(otsuThreshold(values), 1000);
  EXPECT_GT(foregroundThreshold(values), 0);
  EXPECT_LT(foregroundThreshold(values), 100);
  std::vector<float> binary(10000, 0);
  for (int p = 0; p < 50; ++p)
    binary[p] = 1;
  EXPECT_EQ(foregroundThreshold(binary), otsuThreshold(binary)) << "nothing but air is left";
}

TEST(BodyMask, KeepsAllComponentsWhereNoneHasHalfOfTheVoxels) {
  const Volume tubes = volumeOf(grid(40, 40, 8), [](auto i, auto j, auto) {
    return i % 10 < 4 && j % 10 < 4 ? 100.0 : 0.0; // sixteen tubes
  });
  const auto mask = bodyMask(tubes);
  for (std::size_t v = 0; v < mask.size(); ++v)
    ASSERT_EQ(mask[v] != 0, tubes.voxels[v] > 0) << v;
}

TEST(BodyMask, OfAConstantImageIsAllOfIt) {
  for (std::uint8_t m : bodyMask(volumeOf(grid(5, 5, 5), [](auto, auto, auto) { return 3; })))
    ASSERT_EQ(m, 1);
}
