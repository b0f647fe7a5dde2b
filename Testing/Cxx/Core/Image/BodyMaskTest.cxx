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

TEST(BodyMask, OfAConstantImageIsAllOfIt) {
  for (std::uint8_t m : bodyMask(volumeOf(grid(5, 5, 5), [](auto, auto, auto) { return 3; })))
    ASSERT_EQ(m, 1);
}
