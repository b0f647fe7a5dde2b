#include "Core/Alignment/BiasCorrection.h"

#include "Core/Alignment/HistogramSharpening.h"
#include "Core/Image/Simulate.h"
#include "HeadPhantom.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace innergs {
namespace {

constexpr std::int64_t kScanWidth = 72;

using Shading = std::function<double(const Vec3&)>; // of coordinates from −1 to 1 over the phantom

double flat(const Vec3&) {
  return 1;
}
double bright(const Vec3& u) {
  return 1 + 0.4 * (0.8 * u[0] - 0.4 * u[1] * u[1] + 0.2);
}
double dark(const Vec3& u) {
  return 1 - 0.4 * (0.7 * u[1] + 0.3 * u[2] * u[0]);
}

Vec3 unitOf(const Vec3& x) {
  Vec3 u;
  for (int a = 0; a < 3; ++a)
    u[a] = 2 * (x[a] + 0.5) / kScanWidth - 1;
  return u;
}

/// Three orthogonal scans of 4 mm slices, each with its own shading.
std::vector<Stack> scans(const std::vector<Shading>& shadings, double noise = 1) {
  const Volume truth = testing::headPhantom(kScanWidth);
  std::vector<Stack> stacks;
  for (std::size_t s = 0; s < shadings.size(); ++s) {
    Stack stack = simulateThickStack(truth, 2 - static_cast<int>(s), 4, noise, s + 1);
    const GridGeometry& g = stack.image.geometry;
    const Affine3 map = g.indexToWorld();
    for (std::int64_t v = 0; v < g.voxelCount(); ++v)
      stack.image.voxels[v] *= static_cast<float>(shadings[s](
          unitOf(map({static_cast<double>(v % g.size[0]), static_cast<double>(v / g.size[0] % g.size[1]),
                      static_cast<double>(v / (g.size[0] * g.size[1]))}))));
    stacks.push_back(std::move(stack));
  }
  return stacks;
}

/// The spread of log(found) − log(true) between scans over the phantom's ball: how far they still differ.
double errorBetween(const BiasCorrection& found, const std::vector<Shading>& truth) {
  double squared = 0, count = 0;
  std::vector<double> first;
  for (std::size_t s = 1; s < truth.size(); ++s) {
    std::vector<double> rest;
    double mean = 0;
    for (int n = 0; n < 9 * 9 * 9; ++n) {
      const Vec3 u{0.15 * (n % 9 - 4), 0.15 * (n / 9 % 9 - 4), 0.15 * (n / 81 - 4)};
      if (norm(u) > 0.75) continue;
      Vec3 x;
      for (int a = 0; a < 3; ++a)
        x[a] = 0.5 * (u[a] + 1) * kScanWidth - 0.5;
      rest.push_back(found.scans[s].field.logAt(x) - found.scans[0].field.logAt(x) -
                     std::log(truth[s](u) / truth[0](u)));
      mean += rest.back();
    }
    mean /= static_cast<double>(rest.size());
    for (const double r : rest)
      squared += (r - mean) * (r - mean);
    count += static_cast<double>(rest.size());
  }
  return std::sqrt(squared / count);
}

TEST(BiasCorrection, FindsTheShadingBetweenScansToAFewPercent) {
  ThreadPool pool(2);
  const std::vector<Shading> truth{flat, bright, dark};
  const std::vector<Stack> stacks = scans(truth);
  std::vector<StackAlignment> alignment = alignStacks(stacks, pool);
  const BiasCorrection found = findBias(stacks, alignment, false, pool);
  ASSERT_EQ(found.scans.size(), 3u);
  EXPECT_LT(errorBetween(found, truth), 0.02);
  EXPECT_GT(found.psnrAfter, found.psnrBefore + 5);
  EXPECT_LT(found.scans[1].lowest, 0.85);
  EXPECT_GT(found.scans[1].highest, 1.15);
  for (const StackAlignment& a : alignment) {
    EXPECT_TRUE(a.fits);
    EXPECT_LT(a.displacement, 0.3);
  }
  EXPECT_EQ(biasSentence(found.scans[1], "Scan 2").find("Scan 2 is shaded by 0."), 0u);
  EXPECT_GT(found.sharedDeviation, 0);
  EXPECT_LE(found.sharedDeviation, found.sharedHighest > found.sharedLowest ? 0.025 : 0.2);
}

/// Scans that overlap in part: what was seen there is not continued beyond, where nothing tells it.
TEST(BiasCorrection, DoesNotExtrapolate) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans({bright, dark}, 5);
  Volume& axial = stacks[0].image;
  axial.geometry.size[2] = axial.geometry.size[2] / 2;
  axial.voxels.resize(static_cast<std::size_t>(axial.geometry.voxelCount()));
  std::vector<StackAlignment> still(2);
  const BiasCorrection found = findBias(stacks, still, true, pool);
  ASSERT_EQ(found.scans.size(), 2u);
  for (std::size_t s = 0; s < 2; ++s) {
    double low = 0, high = 0;
    for (int n = 0; n < 20 * 20 * 20; ++n) {
      const double at =
          found.scans[s].field.logAt({4.0 * (n % 20) - 2, 4.0 * (n / 20 % 20) - 2, 4.0 * (n / 400) - 2});
      low = std::min(low, at);
      high = std::max(high, at);
    }
    EXPECT_GT(low, -0.6) << s;
    EXPECT_LT(high, 0.6) << s;
  }
}

TEST(BiasCorrection, CanGiveAllScansTheShadingOfTheFirst) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans({bright, flat, dark});
  std::vector<StackAlignment> still;
  const BiasCorrection found = findBias(stacks, still, false, pool);
  ASSERT_EQ(found.scans.size(), 3u);
  const std::vector<float> first = stacks[0].image.voxels;
  for (std::size_t s = 0; s < 3; ++s)
    applyBias(found.scans[s], stacks[s], pool, &found.scans[0]);
  EXPECT_EQ(stacks[0].image.voxels, first);
  EXPECT_TRUE(findBias(stacks, still, false, pool).scans.empty()) << "no difference is left";
  EXPECT_NE(biasSentence(found, "ax").find("that of ax"), std::string::npos);
}

TEST(BiasCorrection, TellsShadingFromMotion) {
  ThreadPool pool(2);
  std::vector<StackAlignment> still;
  const BiasCorrection shaded = findShading(scans({flat, bright, dark}), still, pool);
  EXPECT_EQ(shaded.scans.size(), 3u);
  EXPECT_NE(shadingSentence(shaded).find("--bias-field auto"), std::string::npos);
  std::vector<Stack> moved = scans({flat, flat, flat});
  EXPECT_TRUE(findShading(moved, still, pool).scans.empty());
  moved[1].image.geometry.origin[0] += 2;
  moved[2].image.geometry.origin[1] -= 1.5;
  std::vector<StackAlignment> alignment = alignStacks(moved, pool);
  const BiasCorrection none = findShading(moved, alignment, pool);
  EXPECT_TRUE(none.scans.empty()) << none.psnrBefore << " to " << none.psnrAfter << " dB";
  EXPECT_EQ(shadingSentence(none), "");
}

TEST(BiasCorrection, FindsItTogetherWithMotionAndGain) {
  ThreadPool pool(2);
  const std::vector<Shading> truth{flat, bright, dark};
  std::vector<Stack> stacks = scans(truth);
  stacks[1].image.geometry.origin[1] += 2;
  for (float& v : stacks[2].image.voxels)
    v *= 3;
  std::vector<StackAlignment> alignment = alignStacks(stacks, pool);
  const BiasCorrection found = findBias(stacks, alignment, false, pool);
  ASSERT_EQ(found.scans.size(), 3u);
  EXPECT_NEAR(alignment[1].toOthers(Vec3{36, 36, 36})[1], 34, 0.3);
  applyAlignment(alignment, stacks);
  for (std::size_t s = 0; s < 3; ++s)
    applyBias(found.scans[s], stacks[s], pool);
  const std::vector<StackAlignment> rest = alignStacks(stacks, pool);
  EXPECT_NEAR(rest[2].gain, 1, 0.02);
  EXPECT_LT(rest[1].displacement, 0.3);
}

TEST(BiasCorrection, LeavesUnshadedScansAlone) {
  ThreadPool pool(2);
  for (const double noise : {0.0, 1.0, 8.0}) {
    const std::vector<Stack> stacks = scans({flat, flat, flat}, noise);
    std::vector<StackAlignment> alignment = alignStacks(stacks, pool);
    const BiasCorrection found = findBias(stacks, alignment, false, pool);
    EXPECT_TRUE(found.scans.empty()) << noise;
    EXPECT_EQ(biasSentence(found), "");
    EXPECT_EQ(found.sharedDeviation, 0) << noise;
  }
}

TEST(BiasCorrection, LeavesValuesBelowZeroAndSingleScansAlone) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans({flat, bright, dark});
  std::vector<StackAlignment> none;
  EXPECT_TRUE(findBias(std::span(stacks).first(1), none, true, pool).scans.empty());
  for (Stack& stack : stacks)
    for (float& v : stack.image.voxels)
      v -= 50;
  EXPECT_TRUE(findBias(stacks, none, true, pool).scans.empty());
}

TEST(BiasCorrection, LeavesOutScansOfAnotherContrast) {
  ThreadPool pool(2);
  std::vector<Stack> stacks = scans({flat, bright, dark});
  for (float& v : stacks[2].image.voxels)
    if (v > 20) v = 220 - v;
  std::vector<StackAlignment> none;
  const BiasCorrection found = findBias(stacks, none, false, pool);
  ASSERT_EQ(found.scans.size(), 3u);
  EXPECT_TRUE(found.scans[2].field.coefficients.empty());
  EXPECT_FALSE(found.scans[1].field.coefficients.empty());
}

TEST(BiasCorrection, IsTheSameByAnyNumberOfThreads) {
  const std::vector<Stack> stacks = scans({flat, bright, dark});
  std::vector<BiasCorrection> found;
  for (const int threads : {1, 3}) {
    ThreadPool pool(threads);
    std::vector<StackAlignment> none;
    found.push_back(findBias(stacks, none, false, pool));
  }
  ASSERT_EQ(found[0].scans.size(), 3u);
  for (std::size_t s = 0; s < 3; ++s)
    EXPECT_EQ(found[0].scans[s].field.coefficients, found[1].scans[s].field.coefficients);
}

TEST(HistogramSharpening, FindsTheShadingOfTwoTissues) {
  std::vector<double> logs, terms;
  for (int n = 0; n < 20000; ++n) {
    const double x = n % 100 / 50.0 - 1, y = n / 100 / 100.0 - 1;
    const bool tissue = (n % 100 / 7 + n / 100 / 9) % 2;
    logs.push_back(std::log(tissue ? 150 : 100) + 0.2 * x - 0.1 * y * y);
    for (const double term : {x, y, y * y})
      terms.push_back(term);
  }
  const std::vector<double> found = sharpestShading(logs, terms, 3, [] {});
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0], 0.2, 0.01);
  EXPECT_NEAR(found[1], 0, 0.01);
  EXPECT_NEAR(found[2], -0.1, 0.02);
}

/// Two tissues, more of the brighter one on one side, and most voxels hold some of both.
TEST(HistogramSharpening, IsHardlyMisledByPartialVolumesOfUnevenlySpreadTissues) {
  const auto spread = [](int n, double step) { return std::fmod(n * step, 1.0); };
  for (const double brighter : {133.0, 160.0}) {
    std::vector<double> logs, terms;
    for (int n = 0; n < 20000; ++n) {
      const double x = n % 100 / 50.0 - 1, y = n / 100 / 100.0 - 1, share = 0.5 + 0.45 * x;
      const bool mixed = spread(n, 0.7548776662) < 0.7;
      const double part = mixed ? std::clamp(share + spread(n, 0.5698402910) - 0.5, 0.0, 1.0)
                                : spread(n, 0.6180339887) < share;
      logs.push_back(std::log(100 + (brighter - 100) * part) + 0.2 * x - 0.1 * y * y);
      for (const double term : {x, y, y * y})
        terms.push_back(term);
    }
    const std::vector<double> found = sharpestShading(logs, terms, 3, [] {});
    ASSERT_EQ(found.size(), 3u);
    EXPECT_NEAR(found[0], 0.2, 0.005) << brighter;
    EXPECT_NEAR(found[1], 0, 0.005) << brighter;
    EXPECT_NEAR(found[2], -0.1, 0.005) << brighter;
  }
}

} // namespace
} // namespace innergs
