#include "Core/Uncertainty/SliceDistance.h"

#include "Core/Acquisition/Observation.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

/// Maps voxels of the grid to a slice's own indices, with K as the distance from its middle.
struct SliceMap {
  const Stack* stack;
  std::int64_t slice;
  Affine3 map; // grid index → (i, j, slice distances)
};

bool observedAt(const Stack& stack, std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto& n = stack.image.geometry.size;
  const std::size_t v = static_cast<std::size_t>(i + n[0] * (j + n[1] * k));
  return isKnown(stack, v);
}

/// Calls visit(voxel, stack, distance in mm) for every voxel of a line and each observed slice within
/// 1.5 slice distances of it.
template <typename Visit>
void visitSlices(const GridGeometry& grid, std::span<const Stack> stacks, ThreadPool& pool,
                 const Visit& visit) {
  std::vector<SliceMap> slices; // one per slice of posed stacks, one for any other stack
  for (const Stack& stack : stacks) {
    const Affine3 toIndex = inverse(stack.image.geometry.indexToWorld());
    const std::int64_t count = stack.poses.empty() ? 1 : stack.image.geometry.size[2];
    for (std::int64_t k = 0; k < count; ++k) {
      Affine3 map = stack.poses.empty() ? toIndex : toIndex * inverse(stack.poses[k]);
      slices.push_back({&stack, stack.poses.empty() ? -1 : k, map * grid.indexToWorld()});
    }
  }
  const auto& n = grid.size;
  pool.run(n[2], [&](std::int64_t z) {
    for (const SliceMap& s : slices) {
      const auto& size = s.stack->image.geometry.size;
      const double spacing = s.stack->image.geometry.spacing[2];
      for (std::int64_t y = 0; y < n[1]; ++y)
        for (std::int64_t x = 0; x < n[0]; ++x) {
          const Vec3 at = s.map({static_cast<double>(x), static_cast<double>(y), static_cast<double>(z)});
          const std::int64_t i = std::llround(at[0]), j = std::llround(at[1]);
          if (i < 0 || j < 0 || i >= size[0] || j >= size[1]) continue;
          const std::int64_t middle = std::llround(at[2]);
          const std::int64_t first = s.slice >= 0 ? s.slice : std::max<std::int64_t>(0, middle - 1);
          const std::int64_t last = s.slice >= 0 ? s.slice : std::min(size[2] - 1, middle + 1);
          for (std::int64_t k = first; k <= last; ++k) {
            const double distance = std::abs(at[2] - static_cast<double>(k));
            if (distance <= 1.5 && observedAt(*s.stack, i, j, k))
              visit(static_cast<std::size_t>(x + n[0] * (y + n[1] * z)), *s.stack, distance * spacing);
          }
        }
    }
  });
}

} // namespace

std::vector<float> sliceDistances(const GridGeometry& grid, std::span<const Stack> stacks, ThreadPool& pool) {
  std::vector<float> near(static_cast<std::size_t>(grid.voxelCount()),
                          std::numeric_limits<float>::infinity());
  visitSlices(grid, stacks, pool, [&](std::size_t v, const Stack& stack, double distance) {
    near[v] = std::min(near[v], static_cast<float>(2 * distance / stack.image.geometry.spacing[2]));
  });
  return near;
}

std::vector<std::uint8_t> measuredVoxels(const GridGeometry& grid, std::span<const Stack> stacks,
                                         ThreadPool& pool) {
  std::vector<std::uint8_t> measured(static_cast<std::size_t>(grid.voxelCount()), 0);
  const double voxel = *std::min_element(grid.spacing.begin(), grid.spacing.end());
  visitSlices(grid, stacks, pool, [&](std::size_t v, const Stack& stack, double distance) {
    const double thickness = stack.profile == SliceProfile::Point ? 0 : effectiveThickness(stack);
    if (distance <= 0.5 * std::max(thickness, voxel) + 1e-3) measured[v] = 1;
  });
  return measured;
}

} // namespace innergs
