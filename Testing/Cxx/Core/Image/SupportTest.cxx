#include "Core/Image/Support.h"
#include "Core/Base/Error.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "TestVolumes.h"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <random>

using namespace innergs;
using namespace innergs::testing;

namespace {

Mask ballIn(const GridGeometry& geometry, const Vec3& centre, double radius) {
  return maskInSpace(geometry, [&](const Vec3& x) { return norm(x - centre) < radius; });
}

/// A scan on the mask's own grid.
std::vector<Stack> scanIn(const Mask& mask) {
  Stack stack;
  stack.image.geometry = mask.geometry;
  stack.observed = mask.voxels;
  return {stack};
}

std::int64_t count(const Mask& mask) {
  return std::count_if(mask.voxels.begin(), mask.voxels.end(), [](std::uint8_t v) { return v != 0; });
}

/// Distance (mm) of every voxel of `geometry` to the nearest centre of a mask's voxel.
std::vector<double> distances(const GridGeometry& geometry, const Mask& mask) {
  std::vector<Vec3> set;
  const auto& n = mask.geometry.size;
  for (std::int64_t v = 0; v < mask.geometry.voxelCount(); ++v)
    if (mask.voxels[v])
      set.push_back(
          mask.geometry.indexToWorld()({double(v % n[0]), double(v / n[0] % n[1]), double(v / n[0] / n[1])}));
  std::vector<double> result;
  volumeInSpace(geometry, [&](const Vec3& x) {
    double nearest = 1e300;
    for (const Vec3& y : set)
      nearest = std::min(nearest, norm(x - y));
    result.push_back(nearest);
    return 0;
  });
  return result;
}

/// Gaussians all over a box, with values far outside [0, 1] where few of them overlap.
GaussianField wildField(const GridGeometry& domain) {
  GaussianField field;
  field.modelToWorld = {obliqueDirection(0.5), domain.centre()};
  field.intensityScale = 100;
  field.intensityOffset = -20;
  field.domain = domain;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(-1, 1);
  for (int i = 0; i < 400; ++i) {
    Gaussian g{};
    for (int a = 0; a < 3; ++a) {
      g.mean[a] = 14 * u(random);
      g.logScale[a] = 0.7f + 0.4f * u(random);
      g.quaternion[a + 1] = u(random);
    }
    g.quaternion[0] = 1;
    g.intensity = 0.5f + 3 * u(random);
    field.gaussians.push_back(g);
  }
  return field;
}

const GridGeometry kDomain = grid(20, 22, 18, {1, 1.2, 1.5}, {-8, 30, 4}, obliqueDirection(0.4, true));

GaussianField maskedField() {
  GaussianField field = wildField(kDomain);
  const Mask mask = ballIn(kDomain, kDomain.centre() + Vec3{1, -2, 2}, 5);
  field.support = supportOf(std::vector{mask}, scanIn(mask), kDomain, 1.5);
  field.fill = -77;
  field.range = {0, 100};
  return field;
}

} // namespace

TEST(Support, ReachesTheMarginBeyondTheMaskAndNoFurther) {
  for (const double margin : {0.0, 1.0, 2.6, 4.5}) {
    const Mask mask = ballIn(kDomain, kDomain.centre(), 4);
    const Mask support = supportOf(std::vector{mask}, scanIn(mask), kDomain, margin);
    const std::vector<double> distance = distances(kDomain, mask);
    const std::int64_t expected =
        std::count_if(distance.begin(), distance.end(), [&](double d) { return d <= margin + 1e-6; });
    EXPECT_EQ(count(support), expected) << margin;
    // On the domain's own voxels, and no larger than necessary.
    const Vec3 first = inverse(kDomain.indexToWorld())(support.geometry.origin);
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(first[a], std::round(first[a]), 1e-9);
    const std::vector<double> own = distances(support.geometry, mask);
    for (std::size_t v = 0; v < own.size(); ++v)
      ASSERT_EQ(support.voxels[v] != 0, own[v] <= margin + 1e-6) << margin;
  }
}

TEST(Support, OfThickSlicesReachesNoScannedPointBeyondTheMargin) {
  GridGeometry thick = withSpacing(kDomain, {1, 1.2, 4.5});
  const Mask mask = ballIn(thick, kDomain.centre(), 6);
  const Mask support = supportOf(std::vector{mask}, scanIn(mask), kDomain, 4.5);
  GaussianField field = wildField(kDomain);
  field.support = support;
  field.fill = -77;
  const Volume scanned = render(field, thick), fine = render(field, kDomain);
  const std::vector<double> far = distances(thick, mask);
  for (std::size_t v = 0; v < far.size(); ++v) {
    if (far[v] == 0) {
      ASSERT_NE(scanned.voxels[v], -77);
    } else if (far[v] > 4.5 + 1e-6) {
      ASSERT_EQ(scanned.voxels[v], -77) << far[v];
    }
  }
  const std::vector<double> fineFar = distances(kDomain, mask);
  double furthest = 0;
  for (std::size_t v = 0; v < fineFar.size(); ++v)
    if (fine.voxels[v] != -77) furthest = std::max(furthest, fineFar[v]);
  EXPECT_LE(furthest, 4.5 + 1e-6);
  EXPECT_GT(furthest, 2.5);
}

TEST(Support, OfOneVoxelBetweenTheDomainsIsAround) {
  GridGeometry fine = grid(1, 1, 1, {0.1, 0.1, 0.1}, kDomain.centre() + Vec3{0.2, 0.3, -0.3});
  Stack stack; // one observed voxel there
  stack.image = Volume{fine, {5}};
  stack.observed = {1};
  const Mask support = supportOf(std::vector{Mask{fine, {1}}}, std::vector{stack}, kDomain, 0);
  EXPECT_EQ(count(support), 1);
  EXPECT_LT(norm(support.geometry.centre() - fine.origin), 1.2);
  fine.origin[1] += 300;
  EXPECT_THROW(supportOf(std::vector{Mask{fine, {1}}}, {}, kDomain, 3), Error);
}

TEST(Support, CountsForEveryQueryAlike) {
  const GaussianField field = maskedField();
  GridGeometry oblique = grid(40, 37, 3, {0.7, 0.6, 2}, {0, 0, 0}, obliqueDirection(1.1));
  oblique.origin = oblique.origin + kDomain.centre() - oblique.centre();
  PlaneSampler sampler(std::make_shared<const GaussianField>(field), 2);
  for (const GridGeometry& geometry :
       {kDomain, withSpacing(kDomain, {2, 2.4, 3}), withSpacing(kDomain, {0.5, 0.6, 0.75}), oblique,
        cropped(kDomain, {2, 3, 4}, {3, 3, 3})}) {
    const Volume volume = render(field, geometry);
    const std::vector<Vec3> points = pointsOf(geometry);
    const std::vector<float> single = renderPoints(field, points);
    const Volume scanned = renderStack(field, pointStack({geometry, std::vector<float>(points.size())}));
    const std::size_t plane = static_cast<std::size_t>(geometry.size[0] * geometry.size[1]);
    std::int64_t inside = 0;
    for (std::int64_t k = 0; k < geometry.size[2]; ++k) {
      Affine3 map = geometry.indexToWorld();
      map.offset = map({0, 0, double(k)});
      std::vector<float> slice(plane);
      sampler.sample(map, int(geometry.size[0]), int(geometry.size[1]), slice);
      for (std::size_t p = 0; p < plane; ++p) {
        const std::size_t v = k * plane + p;
        ASSERT_NEAR(volume.voxels[v], single[v], 1e-3); // 1e-5 of the range
        ASSERT_NEAR(slice[p], single[v], 1e-3);
        ASSERT_NEAR(scanned.voxels[v], single[v], 1e-3);
        ASSERT_TRUE(volume.voxels[v] == -77 || (volume.voxels[v] >= 0 && volume.voxels[v] <= 100));
        inside += volume.voxels[v] != -77;
      }
    }
    if (geometry == kDomain) {
      EXPECT_EQ(inside, count(field.support));
    }
  }
}

TEST(Support, LeavesOtherChannelsAndTheFitsViewAlone) {
  GaussianField field = maskedField();
  RenderOptions options;
  options.bounded = false;
  GaussianField plain = field;
  plain.support = {};
  plain.range.reset();
  EXPECT_EQ(render(field, kDomain, options).voxels, render(plain, kDomain).voxels);
  const std::vector<float> channel(field.gaussians.size(), 500.f);
  options.bounded = true;
  options.values = channel;
  const Volume other = render(field, kDomain, options);
  EXPECT_GT(*std::max_element(other.voxels.begin(), other.voxels.end()), 400)
      << "of another kind than the range";
  EXPECT_EQ(std::count_if(other.voxels.begin(), other.voxels.end(), [](float x) { return x != 0; }),
            count(field.support));
}

TEST(Support, AndRangeAreNotNeeded) {
  const GaussianField field = wildField(kDomain);
  const Volume volume = render(field, kDomain);
  EXPECT_LT(*std::min_element(volume.voxels.begin(), volume.voxels.end()), -20);
  EXPECT_GT(*std::max_element(volume.voxels.begin(), volume.voxels.end()), 120);
  EXPECT_EQ(renderPoints(field, std::vector<Vec3>{kDomain.centre() + Vec3{200, 0, 0}})[0], -20);
}
