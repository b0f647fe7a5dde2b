#include "Core/Prediction/PlaneFusion.h"

#include <cmath>
#include <gtest/gtest.h>

namespace innergs {
namespace {

/// A wave along the axis, fused with itself after `add` was added: the result's weight of what was not.
double weightOf(int axis, float add, int threads) {
  constexpr std::int64_t n = 40;
  std::vector<float> wave;
  for (std::int64_t k = 0; k < n; ++k)
    for (std::int64_t j = 0; j < n; ++j)
      for (std::int64_t i = 0; i < n; ++i)
        wave.push_back(std::sin(0.5f * static_cast<float>(axis == 0 ? i : axis == 1 ? j : k)));
  std::array<std::vector<float>, 2> predicted{wave, wave};
  for (float& v : predicted[1])
    v += add;
  ThreadPool pool(threads);
  const std::vector<float> fused = fusedPlanes(predicted, {n, n, n}, pool);
  double sum = 0;
  for (std::size_t v = 0; v < wave.size(); ++v)
    sum += 1 - (fused[v] - wave[v]) / add;
  return sum / static_cast<double>(wave.size());
}

TEST(PlaneFusion, TakesThePlanesThatShowTheStructure) {
  EXPECT_NEAR(weightOf(0, 0.25f, 2), 1, 1e-4);
  EXPECT_NEAR(weightOf(1, 0.25f, 2), 0, 1e-4);
  EXPECT_NEAR(weightOf(2, 0.25f, 2), 0.5, 1e-4) << "neither shows more";
}

TEST(PlaneFusion, IsTheSameForAnyNumberOfThreads) {
  EXPECT_EQ(weightOf(0, 0.3f, 1), weightOf(0, 0.3f, 3));
}

} // namespace
} // namespace innergs
