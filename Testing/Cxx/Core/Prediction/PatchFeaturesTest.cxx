#include "Core/Prediction/PatchFeatures.h"

#include "Core/Base/Random.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

constexpr int kStack = 8, kColumns = 10, kBefore = 1, kAfter = 2;

/// 1000 + values in −1 … 1: nothing of the offset may remain.
std::vector<float> randomSlices() {
  Random random(13);
  std::vector<float> low(kStack * kColumns);
  for (float& v : low)
    v = 1000 + static_cast<float>(2 * random.uniform() - 1);
  return low;
}

/// The image continued by reflection.
double at(const std::vector<float>& low, int slice, int column) {
  const auto reflected = [](int i, int n) { return i < 0 ? -i : i < n ? i : 2 * (n - 1) - i; };
  return low[reflected(slice, kStack) * kColumns + reflected(column, kColumns)];
}

TEST(PatchFeatures, ArePatchesWithoutTheirMeanOverTheirDeviation) {
  const std::vector<float> low = randomSlices();
  for (const float floor : {0.f, 0.3f}) {
    PatchFeatures features;
    makeFeatures(low.data(), kStack, kColumns, floor, features, kBefore, kAfter);
    ASSERT_EQ(features.slices, kStack + kBefore + kAfter);
    for (int s = 0; s < features.slices; ++s)
      for (int c = 0; c < kColumns; ++c) {
        std::vector<double> patch;
        double sum = 0, squares = 0;
        for (int r = -4; r <= 4; ++r)
          for (int i = -3; i <= 3; ++i)
            sum += patch.emplace_back(at(low, s - kBefore + r, c + i));
        const double mean = sum / 63;
        for (double& v : patch)
          squares += (v - mean) * (v - mean);
        const double deviation = floor > 0 ? std::sqrt(squares / 63 + floor * floor) : 1;
        const std::int64_t sample = features.at(s, c);
        EXPECT_NEAR(features.mean[sample], mean, 1e-3);
        EXPECT_NEAR(features.deviation[sample], deviation, 1e-6);
        const float* values = features.values.data() + sample * PatchFeatures::stride;
        for (int n = 0; n < 63; ++n)
          ASSERT_NEAR(values[n], (patch[n] - mean) / deviation, 5e-4) << s << " " << c << " " << n;
        EXPECT_EQ(values[63], 0);
      }
  }
}

TEST(PatchFeatures, OfAConstantImageAreZero) {
  const std::vector<float> low(kStack * kColumns, 1234.567f);
  PatchFeatures features;
  makeFeatures(low.data(), kStack, kColumns, 0.5f, features);
  for (const float v : features.values)
    ASSERT_NEAR(v, 0, 1e-3);
  EXPECT_NEAR(features.deviation[features.at(2, 3)], 0.5, 1e-6);
}

TEST(PatchFeatures, OnlySpansAreComputed) {
  const std::vector<float> low = randomSlices();
  std::vector<ColumnSpan> spans(kStack);
  spans[1] = {0, 4};
  spans[3] = {6, kColumns};
  PatchFeatures whole, part;
  makeFeatures(low.data(), kStack, kColumns, 0.3f, whole);
  makeFeatures(low.data(), kStack, kColumns, 0.3f, part, 0, 0, spans);
  for (int s = 0; s < kStack; ++s)
    for (int c = 0; c < kColumns; ++c) {
      const bool inside = c >= spans[s].first && c < spans[s].last;
      const std::int64_t sample = part.at(s, c);
      EXPECT_EQ(part.deviation[sample], inside ? whole.deviation[sample] : 0) << s << " " << c;
      for (int n = 0; inside && n < PatchFeatures::stride; ++n)
        ASSERT_EQ(part.values[sample * PatchFeatures::stride + n],
                  whole.values[sample * PatchFeatures::stride + n]);
    }
}

} // namespace
} // namespace innergs
