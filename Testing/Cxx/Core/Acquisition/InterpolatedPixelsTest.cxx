#include "Core/Acquisition/InterpolatedPixels.h"

#include "Alignment/HeadPhantom.h"
#include "Core/Acquisition/BackProjection.h"
#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Image/Simulate.h"
#include "Core/Render/Render.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kHeadWidth = 48;

/// A head in slices of 4 mm with noise of this standard deviation.
Stack noisyHead(double noise) {
  return simulateThickStack(testing::headPhantom(kHeadWidth), 2, 4, noise, 3);
}

/// The stack in smaller pixels, as by zero filling: factor < 1.
Stack filled(const Stack& stack, const std::array<double, 2>& factors) {
  ThreadPool pool(1);
  return withLargerPixels(stack, factors, pool);
}

std::array<double, 2> factorsOf(const Stack& stack, int threads = 1) {
  ThreadPool pool(threads);
  return interpolationFactors(stack, pool);
}

TEST(InterpolatedPixels, AreFoundAlongEachAxis) {
  const Stack acquired = noisyHead(6);
  EXPECT_EQ(factorsOf(acquired), (std::array<double, 2>{1, 1})) << "as acquired";
  const auto both = factorsOf(filled(acquired, {0.5, 0.5}));
  EXPECT_GE(both[0], 1.75);
  EXPECT_LE(both[0], 2);
  EXPECT_GE(both[1], 1.75);
  EXPECT_LE(both[1], 2);
  const auto rows = factorsOf(filled(acquired, {1, 2.0 / 3}));
  EXPECT_EQ(rows[0], 1);
  EXPECT_GE(rows[1], 4.0 / 3);
  EXPECT_LE(rows[1], 1.6);
  EXPECT_EQ(factorsOf(filled(acquired, {0.5, 0.5}), 3), both) << "whatever the number of threads";
}

TEST(InterpolatedPixels, AreLeftWithoutNoise) {
  EXPECT_EQ(factorsOf(filled(noisyHead(0), {0.5, 0.5})), (std::array<double, 2>{1, 1}));
}

/// Coarse enough, waves look like noise.
TEST(InterpolatedPixels, AreNoSmoothWaves) {
  Stack waves = testing::pointStack(testing::headPhantom(kHeadWidth));
  const auto& n = waves.image.geometry.size;
  for (const double length : {4.0, 8.0, 12.0, 20.0}) {
    const double a = 2 * 3.14159265 / length;
    for (std::int64_t v = 0; v < waves.image.geometry.voxelCount(); ++v) {
      const double x = static_cast<double>(v % n[0]) - 24, y = static_cast<double>(v / n[0] % n[1]) - 24,
                   z = static_cast<double>(v / (n[0] * n[1])) - 24;
      waves.image.voxels[v] = static_cast<float>(80 * (1 + 0.3 * std::sin(a * x) * std::cos(0.8 * a * y)) /
                                                 (1 + std::exp(std::hypot(x, y, z) - 14)));
    }
    EXPECT_EQ(factorsOf(waves), (std::array<double, 2>{1, 1})) << length;
  }
}

TEST(InterpolatedPixels, AreNotSoughtInWhatCannotShowThem) {
  const std::array<double, 2> none{1, 1};
  Stack broken = filled(noisyHead(6), {0.5, 0.5});
  broken.image.voxels[1000] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(factorsOf(broken), none);
  Stack constant = noisyHead(6);
  std::fill(constant.image.voxels.begin(), constant.image.voxels.end(), 7.f);
  EXPECT_EQ(factorsOf(constant), none);
  Stack labels = noisyHead(0);
  for (float& v : labels.image.voxels)
    v = v > 50 ? 1 : 0;
  EXPECT_EQ(factorsOf(filled(labels, {0.5, 0.5})), none);
  EXPECT_EQ(factorsOf(testing::pointStack(testing::phantom(testing::grid(20, 20, 5)))), none);
}

TEST(InterpolatedPixels, AreUndoneWithoutLoss) {
  const Stack acquired = noisyHead(6);
  const Stack stored = filled(acquired, {0.5, 0.5});
  ThreadPool pool(2);
  const Stack back = withLargerPixels(stored, {2, 2}, pool);
  const GridGeometry &g = back.image.geometry, &expected = acquired.image.geometry;
  ASSERT_EQ(g.size, expected.size);
  for (int a = 0; a < 3; ++a) {
    EXPECT_NEAR(g.spacing[a], expected.spacing[a], 1e-9);
    EXPECT_NEAR(g.origin[a], expected.origin[a], 1e-9);
  }
  EXPECT_EQ(back.thickness, acquired.thickness);
  double squares = 0, differences = 0;
  for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
    const std::int64_t i = v % g.size[0], j = v / g.size[0] % g.size[1];
    if (std::min({i, j, g.size[0] - 1 - i, g.size[1] - 1 - j}) < 6) continue; // the sinc's lobes are cut
    squares += std::pow(acquired.image.voxels[v], 2);
    differences += std::pow(acquired.image.voxels[v] - back.image.voxels[v], 2);
  }
  EXPECT_LT(std::sqrt(differences / squares), 0.01);
}

TEST(InterpolatedPixels, AreObservedWhereAllOfThemWas) {
  Stack stored = noisyHead(6);
  const std::int64_t nx = stored.image.geometry.size[0];
  stored.observed.assign(stored.image.voxels.size(), 1);
  stored.observed[static_cast<std::size_t>(7 + nx * 10)] = 0;
  ThreadPool pool(1);
  const Stack larger = withLargerPixels(stored, {2, 2}, pool);
  ASSERT_EQ(larger.observed.size(), larger.image.voxels.size());
  for (std::size_t v = 0; v < larger.observed.size(); ++v)
    EXPECT_EQ(larger.observed[v],
              v == static_cast<std::size_t>(3 + larger.image.geometry.size[0] * 5) ? 0 : 1)
        << v;
}

TEST(WidePixels, ShowTheMeanOfFinerOnes) {
  const Volume volume = testing::phantom(testing::grid(24, 24, 12));
  Stack fine = testing::pointStack(volume);
  ThreadPool pool(2);
  Stack wide = withLargerPixels(fine, {2, 2}, pool);
  wide.pixelWidth = 2;
  const std::vector<float> seen = projectToStack(volume, wide, pool);
  const auto n = wide.image.geometry.size;
  for (std::int64_t v = 0; v < wide.image.geometry.voxelCount(); ++v) {
    const std::int64_t i = 2 * (v % n[0]), j = 2 * (v / n[0] % n[1]), k = v / (n[0] * n[1]);
    double sum = 0;
    for (int p = 0; p < 4; ++p)
      sum += volume.voxels[static_cast<std::size_t>(i + p % 2 + 24 * (j + p / 2 + 24 * k))];
    EXPECT_NEAR(seen[v], sum / 4, 1e-3);
  }
}

TEST(WidePixels, OfAFieldAreTheMeanOfItsPoints) {
  testing::Cloud cloud;
  cloud.low = {-5, -5, -5};
  cloud.high = {5, 5, 5};
  GaussianField field = testing::randomField(12, cloud, 5, Blending::Normalised, true);
  Stack stack = testing::pointStack(testing::phantom(testing::grid(6, 5, 4, {2, 2, 2}, {-5, -4, -3})));
  field.domain = withSpacing(stack.image.geometry, {1, 1, 1});
  const auto shown = [&](double width, const Vec3& moved) {
    Stack at = stack;
    at.profile = SliceProfile::Box;
    at.thickness = 2;
    at.pixelWidth = width;
    at.image.geometry.origin = at.image.geometry.origin + moved;
    return renderStack(field, at, {}).voxels;
  };
  const std::vector<float> wide = shown(2, {0, 0, 0});
  std::vector<double> mean(wide.size(), 0.0);
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5}) {
      const std::vector<float> part = shown(0, {x, y, 0});
      for (std::size_t v = 0; v < mean.size(); ++v)
        mean[v] += 0.25 * part[v];
    }
  const auto [least, most] = std::minmax_element(mean.begin(), mean.end());
  ASSERT_GT(*most - *least, 1e-3);
  for (std::size_t v = 0; v < mean.size(); ++v)
    EXPECT_NEAR(wide[v], mean[v], 1e-4 * (*most - *least));
}

TEST(WidePixels, SpreadOverNeighboursBeforeTheyAreBackProjected) {
  EXPECT_EQ(spreadingWeights(SliceProfile::Box, 1.25, 1.25), std::vector<double>{1});
  EXPECT_EQ(spreadingWeights(SliceProfile::Box, 2, 1.25), (std::vector<double>{0.25, 0.5, 0.25}));
}

} // namespace
} // namespace innergs
