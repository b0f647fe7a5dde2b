#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Acquisition/Observation.h"

#include "TestVolumes.h"

#include <cmath>
#include <gtest/gtest.h>
#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// One cubic convolution per voxel and sub-plane.
std::vector<float> projectedPlainly(const Volume& volume, const Stack& stack, float keys) {
  const GridGeometry& g = stack.image.geometry;
  const Affine3 toIndex = inverse(volume.geometry.indexToWorld());
  const Vec3 normal = column(g.direction, 2);
  const Vec3 along = toIndex.linear * normal;
  const ProfileQuadrature planes =
      profileQuadrature(stack.profile, effectiveThickness(stack), 1 / norm(along));
  std::vector<float> seen;
  for (const Vec3& point : pointsOf(g)) {
    double sum = 0, weights = 0;
    for (std::size_t p = 0; p < planes.offset.size(); ++p) {
      const Vec3 x = toIndex(point + planes.offset[p] * normal);
      bool inside = true;
      for (int a = 0; a < 3; ++a)
        inside = inside && std::abs(x[a] - 0.5 * static_cast<double>(volume.geometry.size[a] - 1)) <=
                               0.5 * static_cast<double>(volume.geometry.size[a]) + kIndexRounding;
      if (!inside) continue;
      sum += planes.weight[p] * cubicAt(volume, x, keys);
      weights += planes.weight[p];
    }
    seen.push_back(weights > 0 ? static_cast<float>(sum / weights) : kNaN);
  }
  return seen;
}

} // namespace

TEST(ProjectToStack, IsOneCubicConvolutionPerVoxelAndSubPlane) {
  const Volume volume =
      randomVolume(grid(12, 13, 11, {1, 1.5, 2}, {3, 2, 1}, obliqueDirection(0.5, true)), -50, 50);
  struct Case {
    std::array<int, 3> axes;
    Vec3 step, origin; // voxels of the volume
    double turn = 0;
  };
  ThreadPool pool(2);
  for (const Case& c :
       {Case{{0, 1, 2}, {1, 1, 2}, {0, 0, 0.5}}, Case{{0, 1, 2}, {1, 1, 2.3}, {-2, 3, -0.375}},
        Case{{0, 1, 2}, {-1, 1, -2}, {10, 1, 12}}, Case{{2, 0, 1}, {1, -1, 3}, {10, 0.2, 1}},
        Case{{1, 2, 0}, {2, 1, 1.4}, {0.1, 1, 0}}, Case{{0, 1, 2}, {1, 1, 2}, {0.3, 0, 0}},
        Case{{0, 1, 2}, {1, 1, 2}, {1, 2, 0.5}, 0.1}}) {
    Stack stack;
    GridGeometry& g = stack.image.geometry;
    g = pointsOver(volume.geometry, c.axes, c.step, c.origin);
    if (c.turn != 0) g.direction = obliqueDirection(c.turn) * g.direction;
    stack.image.voxels.assign(static_cast<std::size_t>(g.voxelCount()), 0.f);
    for (const SliceProfile profile : {SliceProfile::Point, SliceProfile::Box, SliceProfile::Gaussian})
      for (const float keys : {kKeys, -0.75f}) {
        stack.profile = profile;
        const std::vector<float> seen = projectToStack(volume, stack, pool, keys),
                                 expected = projectedPlainly(volume, stack, keys);
        std::size_t inside = 0;
        for (std::size_t v = 0; v < seen.size(); ++v) {
          ASSERT_EQ(std::isnan(seen[v]), std::isnan(expected[v])) << v;
          if (std::isnan(seen[v])) continue;
          ASSERT_NEAR(seen[v], expected[v], 2e-3) << v;
          ++inside;
        }
        EXPECT_GT(inside, seen.size() / 5);
      }
  }
}

TEST(ProjectToStack, LeavesOutWhatIsNotObserved) {
  const Volume volume = randomVolume(grid(9, 11, 14), 0, 100);
  Stack stack;
  stack.image.geometry = pointsOver(volume.geometry, {0, 1, 2}, {1, 1, 2}, {0, 0, 0.5});
  stack.image.voxels.assign(9 * 11 * 7, 0.f);
  stack.observed.assign(stack.image.voxels.size(), 1);
  stack.observed[100] = 0;
  ThreadPool pool(2);
  const std::vector<float> seen = projectToStack(volume, stack, pool);
  for (std::size_t v = 0; v < seen.size(); ++v)
    EXPECT_EQ(std::isnan(seen[v]), v == 100);
}

// Voxels that carry no weight may be anything.
TEST(ProjectToStack, ReadsNoVoxelInVain) {
  Volume volume = randomVolume(grid(9, 11, 14), 0, 100);
  std::fill(volume.voxels.begin() + 9 * 11 * 13, volume.voxels.end(), kNaN);
  Stack stack;
  stack.image.geometry = pointsOver(volume.geometry, {0, 1, 2}, {1, 1, 2}, {0, 0, -0.5});
  stack.image.voxels.assign(9 * 11 * 7, 0.f);
  ThreadPool pool(2);
  for (const float v : projectToStack(volume, stack, pool))
    ASSERT_TRUE(std::isfinite(v));
}
