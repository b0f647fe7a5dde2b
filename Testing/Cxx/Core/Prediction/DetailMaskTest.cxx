#include "Core/Prediction/DetailMask.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

TEST(DetailMask, DilatesAsFarAsItReaches) {
  ThreadPool pool(2);
  constexpr std::int64_t n = 9;
  std::vector<std::uint8_t> mask(n * n * n, 0);
  mask[1 + n * (4 + n * 8)] = 1;
  dilate(mask, {n, n, n}, {3, 1, 2}, pool);
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t i = 0; i < n; ++i)
        EXPECT_EQ(mask[i + n * (j + n * k)], i <= 4 && std::abs(j - 4) <= 1 && k >= 6)
            << i << " " << j << " " << k;
}

TEST(DetailMask, HoldsTheBodyAndWhatNoiseDoesNotExplain) {
  ThreadPool pool(2);
  constexpr std::int64_t n = 24;
  FilledImage filled;
  filled.image.geometry.size = {n, n, n};
  filled.image.voxels.assign(n * n * n, 0.f);
  std::vector<std::uint8_t> body(filled.image.voxels.size(), 0);
  const auto at = [](std::int64_t i, std::int64_t j, std::int64_t k) { return i + n * (j + n * k); };
  body[at(4, 4, 4)] = 1;
  filled.image.voxels[at(16, 16, 16)] = 6; // of six times the noise
  filled.image.voxels[at(4, 16, 16)] = 3;
  const std::vector<std::uint8_t> detail = detailMask(filled, body, 1, pool);
  EXPECT_TRUE(detail[at(4, 4, 4)] && detail[at(6, 4, 5)] && detail[at(16, 16, 16)] && detail[at(19, 16, 16)]);
  EXPECT_FALSE(detail[at(7, 4, 4)] || detail[at(4, 4, 6)] || detail[at(20, 16, 16)]);
  EXPECT_FALSE(detail[at(4, 16, 16)]) << "three times the noise";
}

} // namespace
} // namespace innergs
