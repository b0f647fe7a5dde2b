#include "Core/Fit/Initialise.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <algorithm>
#include <gtest/gtest.h>
#include <set>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A bright cube with sharp faces on a flat background.
Stack cubeStack() {
  return pointStack(volumeOf(grid(40, 40, 40), [](auto i, auto j, auto k) {
    return i >= 12 && i < 28 && j >= 12 && j < 28 && k >= 12 && k < 28 ? 200 : 50;
  }));
}

const Affine3 kFrame{Mat3{}, {19.5, 19.5, 19.5}};
const IntensityMap kMap{150, 50};

GaussianField start(const ProxyVolume& proxy, const InitialisationPlan& plan, std::uint64_t seed,
                    int threads = 2, Blending blending = Blending::Normalised) {
  GaussianField field;
  field.blending = blending;
  field.modelToWorld = kFrame;
  ThreadPool pool(threads);
  initialise(field, proxy, plan, seed, pool);
  return field;
}

ProxyVolume cubeProxy() {
  ThreadPool pool(2);
  const std::vector<Stack> stacks{cubeStack()};
  return makeProxy(stacks, kFrame, kMap, 1, pool);
}

/// Distance (mm) to the nearest face of the cube.
double toEdge(const Gaussian& g) {
  double outside = 0, inside = 1e9;
  for (float x : g.mean) {
    const double d = std::abs(x) - 8;
    outside = std::max(outside, d);
    inside = std::min(inside, -d);
  }
  return outside > 0 ? outside : inside;
}

} // namespace

TEST(Proxy, IsTheImageInTheModelFrame) {
  const ProxyVolume proxy = cubeProxy();
  EXPECT_EQ(proxy.geometry.size, (std::array<std::int64_t, 3>{40, 40, 40}));
  const Stack stack = cubeStack();
  for (std::size_t v = 0; v < proxy.voxels.size(); ++v) {
    ASSERT_EQ(proxy.covered[v], 1);
    ASSERT_NEAR(proxy.voxels[v], (stack.image.voxels[v] - 50) / 150, 1e-5);
  }
}

TEST(Proxy, AveragesStacksAndMarksWhatNoneObserves) {
  Stack a, b;
  a.image = volumeOf(grid(10, 10, 10), [](auto, auto, auto) { return 10; });
  b.image = volumeOf(grid(10, 10, 10, {1, 1, 1}, {5, 0, 0}), [](auto, auto, auto) { return 30; });
  a.image.voxels[0] = std::numeric_limits<float>::quiet_NaN();
  b.observed.assign(1000, 1);
  for (std::size_t v = 0; v < 1000; ++v)
    b.observed[v] = v % 10 < 8;
  ThreadPool pool(1);
  const std::vector<Stack> stacks{a, b};
  const ProxyVolume proxy = makeProxy(stacks, {}, {}, 1, pool);
  ASSERT_EQ(proxy.geometry.size, (std::array<std::int64_t, 3>{15, 10, 10}));
  const std::size_t row = 15 * (5 + 10 * 5);
  EXPECT_NEAR(proxy.voxels[row + 2], 10, 1e-5);
  EXPECT_NEAR(proxy.voxels[row + 7], 20, 1e-5);
  EXPECT_NEAR(proxy.voxels[row + 11], 30, 1e-5);
  EXPECT_EQ(proxy.covered[row + 14], 0);
  EXPECT_EQ(proxy.covered[0], 0);
  EXPECT_EQ(proxy.covered[row], 1);
}

TEST(Proxy, CoversTheObservedVoxelsAndNotTheirNeighbours) {
  Stack stack;
  stack.image = volumeOf(grid(8, 8, 6, {1, 1, 4}), [](auto i, auto, auto) { return i; });
  stack.observed.assign(384, 0);
  stack.observed[3 + 8 * (4 + 8 * 2)] = 1;
  ThreadPool pool(1);
  const ProxyVolume proxy = makeProxy({&stack, 1}, {}, {}, 1, pool);
  ASSERT_EQ(proxy.geometry.size, (std::array<std::int64_t, 3>{8, 8, 24}));
  for (std::size_t v = 0; v < proxy.covered.size(); ++v)
    ASSERT_EQ(proxy.covered[v], v % 8 == 3 && v / 8 % 8 == 4 && v / 64 >= 8 && v / 64 < 12) << v;
  // On a coarser grid no point lies in the voxel: its neighbours stand for it.
  const ProxyVolume coarse = makeProxy({&stack, 1}, {}, {}, 2.7, pool);
  EXPECT_GT(std::count(coarse.covered.begin(), coarse.covered.end(), 1), 0);
}

class Start : public ::testing::TestWithParam<Initialisation> {
protected:
  InitialisationPlan plan(std::int64_t gaussians) const {
    InitialisationPlan p;
    p.kind = GetParam();
    p.gaussians = gaussians;
    return p;
  }
};

TEST_P(Start, RespectsTheBudget) {
  const ProxyVolume proxy = cubeProxy();
  for (std::int64_t budget : {64, 500, 3000, 9261}) {
    const GaussianField field = start(proxy, plan(budget), 1);
    EXPECT_GT(field.size(), 0.8 * budget);
    EXPECT_LE(field.size(), budget);
  }
}

TEST_P(Start, IsDeterministicAndFollowsTheSeed) {
  const ProxyVolume proxy = cubeProxy();
  const GaussianField field = start(proxy, plan(2000), 5, 1);
  for (int threads : {2, 3, 5})
    EXPECT_TRUE(sameGaussians(field, start(proxy, plan(2000), 5, threads)));
  EXPECT_FALSE(sameGaussians(field, start(proxy, plan(2000), 6)));
}

TEST_P(Start, IsSortedAlongAMortonCurve) {
  const GaussianField field = start(cubeProxy(), plan(2000), 5);
  const auto order = mortonOrder(field.gaussians);
  for (std::size_t i = 0; i < order.size(); ++i)
    ASSERT_EQ(order[i], i);
  double neighbours = 0;
  for (std::size_t i = 1; i < field.gaussians.size(); ++i)
    for (int a = 0; a < 3; ++a)
      neighbours += std::abs(field.gaussians[i].mean[a] - field.gaussians[i - 1].mean[a]);
  EXPECT_LT(neighbours / static_cast<double>(field.size()), 8.0); // at random: 40 mm
}

TEST_P(Start, TakesPlaceAndIntensityFromTheImage) {
  const GaussianField field = start(cubeProxy(), plan(3000), 5);
  for (const Gaussian& g : field.gaussians) {
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(std::abs(g.mean[a]), 20.5f);
      EXPECT_GT(std::exp(g.logScale[a]), 0.2f);
      EXPECT_LT(std::exp(g.logScale[a]), 15.f);
    }
    const float length = g.quaternion[0] * g.quaternion[0] + g.quaternion[1] * g.quaternion[1] +
                         g.quaternion[2] * g.quaternion[2] + g.quaternion[3] * g.quaternion[3];
    EXPECT_NEAR(length, 1, 1e-5);
    if (toEdge(g) < 1.01) continue;
    const bool inside = std::max({std::abs(g.mean[0]), std::abs(g.mean[1]), std::abs(g.mean[2])}) < 8;
    EXPECT_NEAR(g.intensity, inside ? 1 : 0, 1e-4);
  }
  EXPECT_NO_THROW([&] {
    GaussianField usable = field;
    usable.domain = cubeStack().image.geometry;
    checkField(usable);
  }());
}

TEST_P(Start, LeavesUncoveredSpaceEmpty) {
  ProxyVolume proxy = cubeProxy();
  for (std::size_t v = 0; v < proxy.covered.size(); ++v)
    proxy.covered[v] = v % 40 < 20;
  const GaussianField field = start(proxy, plan(2000), 5);
  EXPECT_GT(field.size(), 500);
  for (const Gaussian& g : field.gaussians)
    EXPECT_LE(g.mean[0], 0.51f);
  std::fill(proxy.covered.begin(), proxy.covered.end(), std::uint8_t{0});
  EXPECT_EQ(start(proxy, plan(2000), 5).size(), 0);
}

TEST_P(Start, SpendsTheBudgetOnWhatIsCovered) {
  ProxyVolume proxy = cubeProxy();
  std::int64_t covered = 0;
  for (std::size_t v = 0; v < proxy.covered.size(); ++v) { // a ball off the centre, 3 % of the box
    const double i = double(v % 40) - 14, j = double(v / 40 % 40) - 22, k = double(v / 1600) - 25;
    proxy.covered[v] = i * i + j * j + k * k < 64;
    covered += proxy.covered[v];
  }
  for (const std::int64_t budget : {60, 300}) {
    const GaussianField field = start(proxy, plan(budget), 1);
    EXPECT_GT(field.size(), 0.75 * budget);
    EXPECT_LE(field.size(), budget + 1);
    double size = 0;
    for (const Gaussian& g : field.gaussians)
      size += std::exp(g.logScale[0]) / static_cast<double>(field.size());
    const double distance = std::cbrt(static_cast<double>(covered) / static_cast<double>(budget));
    EXPECT_NEAR(size, 0.5 * distance, 0.2 * distance);
  }
}

TEST_P(Start, FindsAShellThatSlipsBetweenCells) {
  ProxyVolume proxy = cubeProxy();
  for (std::size_t v = 0; v < proxy.covered.size(); ++v) {
    const double i = double(v % 40) - 20, j = double(v / 40 % 40) - 20, k = double(v / 1600) - 20;
    proxy.covered[v] = std::abs(std::sqrt(i * i + j * j + k * k) - 15) < 0.6;
  }
  for (const std::int64_t budget : {1, 2, 8, 27})
    EXPECT_GT(start(proxy, plan(budget), 1).size(), 0) << budget;
}

INSTANTIATE_TEST_SUITE_P(Kinds, Start, ::testing::Values(Initialisation::Adaptive, Initialisation::Grid),
                         [](const auto& info) {
                           return info.param == Initialisation::Grid ? "Grid" : "Adaptive";
                         });

TEST(AdaptiveStart, PutsMoreAndSmallerGaussiansAtEdges) {
  InitialisationPlan plan;
  plan.gaussians = 4000;
  const GaussianField field = start(cubeProxy(), plan, 1);
  // Voxels within 2 mm of a face, and flat ones farther than 4 mm, counted on the same measure.
  double edgeVoxels = 0, flatVoxels = 0, edge = 0, flat = 0, edgeSize = 0, flatSize = 0;
  for (int k = 0; k < 40; ++k)
    for (int j = 0; j < 40; ++j)
      for (int i = 0; i < 40; ++i) {
        Gaussian g{};
        g.mean[0] = i - 19.5f, g.mean[1] = j - 19.5f, g.mean[2] = k - 19.5f;
        edgeVoxels += toEdge(g) < 2;
        flatVoxels += toEdge(g) > 4;
      }
  for (const Gaussian& g : field.gaussians) {
    if (toEdge(g) < 2) ++edge, edgeSize += std::exp(g.logScale[0]);
    if (toEdge(g) > 4) ++flat, flatSize += std::exp(g.logScale[0]);
  }
  EXPECT_GT(edge / edgeVoxels, 5 * flat / flatVoxels);
  EXPECT_GT(flat, 50); // flat regions are covered too
  EXPECT_LT(edgeSize / edge, 0.7 * flatSize / flat);
}

TEST(AdaptiveStart, SeesNoStructureAtTheBorderOfWhatIsCovered) {
  ThreadPool pool(2);
  Stack stack;
  stack.image = volumeOf(grid(20, 20, 20), [](auto, auto, auto) { return 100; });
  for (std::size_t v = 0; v < 8000; ++v)
    stack.observed.push_back(v % 20 > 4 && v % 20 < 12);
  const ProxyVolume proxy = makeProxy({&stack, 1}, {}, {}, 1, pool);
  for (const float x : structureMeasure(proxy, pool))
    ASSERT_EQ(x, 0);
}

TEST(AdaptiveStart, OfAConstantImageIsEven) {
  Stack stack;
  stack.image = volumeOf(grid(30, 30, 30), [](auto, auto, auto) { return 7; });
  ThreadPool pool(2);
  const std::vector<Stack> stacks{stack};
  const ProxyVolume proxy = makeProxy(stacks, {Mat3{}, {14.5, 14.5, 14.5}}, {1, 7}, 1, pool);
  InitialisationPlan plan;
  plan.gaussians = 1000;
  const GaussianField field = start(proxy, plan, 1);
  EXPECT_NEAR(static_cast<double>(field.size()), 1000, 5);
  int octants[8] = {};
  for (const Gaussian& g : field.gaussians)
    ++octants[(g.mean[0] > 0) + 2 * (g.mean[1] > 0) + 4 * (g.mean[2] > 0)];
  for (int n : octants)
    EXPECT_NEAR(n, 125, 40);
}

TEST(GridStart, HasAsManyAlongEachAxisWhenAsked) {
  Stack stack;
  stack.image = volumeOf(grid(20, 31, 26), [](auto i, auto j, auto) { return i + j; });
  ThreadPool pool(1);
  const ProxyVolume proxy = makeProxy({&stack, 1}, {Mat3{}, {9.5, 15, 12.5}}, {50, 0}, 1, pool);
  InitialisationPlan plan;
  plan.kind = Initialisation::Grid;
  plan.gaussians = 350;
  plan.equalCounts = true;
  const GaussianField field = start(proxy, plan, 1);
  EXPECT_EQ(field.size(), 343);
  for (int a = 0; a < 3; ++a) {
    std::set<float> places;
    for (const Gaussian& g : field.gaussians)
      places.insert(std::round(g.mean[a] * 100));
    EXPECT_EQ(places.size(), 7u);
  }
  // Sizes follow the spacings: 20/7, 31/7 and 26/7 mm.
  const Gaussian& g = field.gaussians.front();
  EXPECT_NEAR(g.logScale[1] - g.logScale[0], std::log(31.0 / 20), 1e-4);

  plan.equalCounts = false; // cubes, but still no more than requested
  EXPECT_LE(start(proxy, plan, 1).size(), 350);
  EXPECT_GT(start(proxy, plan, 1).size(), 280);
}

TEST(LayeredStart, HasOneLayerPerSlice) {
  InitialisationPlan plan;
  plan.kind = Initialisation::Grid;
  plan.gaussians = 2560;
  plan.layerSpacing = 4;
  plan.layerSigma = 5;
  const GaussianField field = start(cubeProxy(), plan, 1);
  std::vector<int> layers(10, 0);
  for (const Gaussian& g : field.gaussians) {
    const double layer = (g.mean[2] + 20) / 4 - 0.5;
    EXPECT_NEAR(layer, std::round(layer), 1e-4);
    ++layers.at(std::lround(layer));
    EXPECT_NEAR(std::exp(g.logScale[2]), 5, 1e-4);
  }
  for (int n : layers)
    EXPECT_EQ(n, 256);
}

TEST(LayeredStart, KeepsItsDensityInsideAMask) {
  InitialisationPlan plan;
  plan.kind = Initialisation::Grid;
  plan.layerSpacing = 4;
  plan.layerSigma = 5;
  plan.gaussians = 160; // a sixteenth of 2560
  ProxyVolume proxy = cubeProxy();
  for (std::size_t v = 0; v < proxy.covered.size(); ++v)
    proxy.covered[v] = v % 40 >= 10 && v % 40 < 20 && v / 40 % 40 >= 20 && v / 40 % 40 < 30;
  const GaussianField field = start(proxy, plan, 1);
  EXPECT_EQ(field.size(), 160);
  for (const Gaussian& g : field.gaussians) {
    EXPECT_NEAR(std::exp(g.logScale[0]), 0.5 * 2.5, 1e-4); // as of all 2560 in the whole
    const double layer = (g.mean[2] + 20) / 4 - 0.5;
    EXPECT_NEAR(layer, std::round(layer), 1e-4);
  }
}

TEST(GridStart, EqualCountsMeanTheCoveredBox) {
  InitialisationPlan plan;
  plan.kind = Initialisation::Grid;
  plan.equalCounts = true;
  plan.gaussians = 216;
  ProxyVolume proxy = cubeProxy();
  for (std::size_t v = 0; v < proxy.covered.size(); ++v)
    proxy.covered[v] = v % 40 < 20;
  const GaussianField field = start(proxy, plan, 1);
  EXPECT_EQ(field.size(), 216);
  for (const Gaussian& g : field.gaussians)
    EXPECT_LT(g.mean[0], 0.5f);
}

TEST(ReachedShare, IsTheShareOfTheStartThatMattersToTheMask) {
  ThreadPool pool(2);
  Stack stack = cubeStack();
  InitialisationPlan plan;
  plan.gaussians = 640;
  const auto share = [&] { return reachedShare({&stack, 1}, kMap, plan, 64000, 1, pool); };
  EXPECT_EQ(share().gaussians, 1);
  stack.observed.assign(64000, 1);
  for (std::size_t v = 0; v < 64000; ++v)
    stack.observed[v] = v / 1600 != 20; // a held-out slice makes no difference
  EXPECT_EQ(share().gaussians, 1);
  for (std::size_t v = 0; v < 64000; ++v) // around the cube's faces, which have all the structure
    stack.observed[v] =
        v % 40 >= 9 && v % 40 < 31 && v / 40 % 40 >= 9 && v / 40 % 40 < 31 && v / 1600 >= 9 && v / 1600 < 31;
  EXPECT_GT(share().gaussians, 0.8);
  plan.kind = Initialisation::Grid; // by volume: 22 voxels and reach on either side
  EXPECT_NEAR(share().gaussians, std::pow((22 + 2 * 2.4) / 40, 3), 0.06);
  EXPECT_EQ(share().volume, share().gaussians);
}

TEST(AdditiveStart, HasAboutTheImagesLevel) {
  // Overlapping Gaussians add up: amplitudes are scaled so that their sum gives the image.
  InitialisationPlan plan;
  plan.kind = Initialisation::Grid;
  plan.gaussians = 8000;
  const GaussianField normalised = start(cubeProxy(), plan, 1);
  const GaussianField additive = start(cubeProxy(), plan, 1, 2, Blending::Additive);
  ASSERT_EQ(normalised.size(), additive.size());
  double sum = 0; // at the cube's centre
  for (const Gaussian& g : additive.gaussians) {
    double m = 0;
    for (int a = 0; a < 3; ++a)
      m += std::pow(g.mean[a] / std::exp(g.logScale[a]), 2);
    sum += g.intensity * std::exp(-0.5 * m);
  }
  EXPECT_NEAR(sum, 1, 0.15);
}
