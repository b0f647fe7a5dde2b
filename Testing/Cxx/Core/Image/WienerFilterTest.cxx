#include "Core/Image/WienerFilter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace innergs {
namespace {

double meanSquare(const std::vector<float>& values) {
  double sum = 0;
  for (const float v : values)
    sum += static_cast<double>(v) * v;
  return sum / static_cast<double>(values.size());
}

std::vector<float> noise(std::size_t pixels, float deviation) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal(0, deviation);
  std::vector<float> values(pixels);
  for (float& v : values)
    v = normal(random);
  return values;
}

TEST(WienerFilter, RemovesNoise) {
  std::vector<float> differences = noise(64 * 48, 2);
  wienerFilter(differences, 64, 2);
  EXPECT_LT(meanSquare(differences), 0.1 * 4);
}

TEST(WienerFilter, KeepsWhatNoiseDoesNotExplain) {
  std::vector<float> structure(64 * 48);
  for (std::size_t p = 0; p < structure.size(); ++p)
    structure[p] = p % 64 < 32 ? -20.f : 20.f;
  std::vector<float> differences = noise(structure.size(), 2);
  for (std::size_t p = 0; p < structure.size(); ++p)
    differences[p] += structure[p];
  wienerFilter(differences, 64, 2);
  for (std::size_t p = 0; p < structure.size(); ++p)
    differences[p] -= structure[p];
  EXPECT_LT(meanSquare(differences), 1.05 * 4);
}

TEST(WienerFilter, WithoutNoiseKeepsAll) {
  const std::vector<float> before = noise(64 * 48, 2);
  std::vector<float> differences = before;
  wienerFilter(differences, 64, 0);
  EXPECT_EQ(differences, before);
}

TEST(WienerFilter, LeavesUnknownDifferencesOut) {
  constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
  std::vector<float> differences(9 * 9, 1.f);
  differences[4 * 9 + 4] = kUnknown;
  wienerFilter(differences, 9, std::sqrt(0.5));
  for (std::size_t p = 0; p < differences.size(); ++p) {
    if (p == 4 * 9 + 4)
      EXPECT_TRUE(std::isnan(differences[p]));
    else
      EXPECT_FLOAT_EQ(differences[p], 0.5f);
  }
}

} // namespace
} // namespace innergs
