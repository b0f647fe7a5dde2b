#include "Core/Fit/Proxy.h"

#include "Core/Image/Bounds.h"
#include "Core/Image/Region.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// Bounding box of the stacks' samples in model coordinates.
Bounds boundsOf(std::span<const Stack> stacks, const Affine3& worldToModel) {
  Bounds bounds;
  for (const Stack& stack : stacks) {
    const GridGeometry& g = stack.image.geometry;
    const Affine3 map = g.indexToWorld();
    const std::int64_t step = stack.poses.empty() ? std::max<std::int64_t>(1, g.size[2] - 1) : 1;
    for (std::int64_t k = 0; k < g.size[2]; k += step) { // both ends, or every slice if each has a pose
      const Affine3 pose = stack.poses.empty() ? Affine3{} : stack.poses[k];
      for (double i : {-0.5, g.size[0] - 0.5})
        for (double j : {-0.5, g.size[1] - 0.5})
          for (double side : {-0.5, 0.5})
            bounds.include(worldToModel(pose(map({i, j, static_cast<double>(k) + side}))));
    }
  }
  return bounds;
}

/// How a stack covers a point.
enum class Coverage : std::uint8_t {
  Not,
  Beside, // next to observed voxels
  Within  // inside one
};

bool isUsable(const Stack& stack, Voxels voxels, std::size_t v) {
  return std::isfinite(stack.image.voxels[v]) &&
         (voxels == Voxels::All || stack.observed.empty() || stack.observed[v]);
}

/// Indices of a stack beyond which no usable voxel is a neighbour.
struct Reach {
  Vec3 low, high;
};

Reach reachOf(const Stack& stack, Voxels voxels) {
  const auto& size = stack.image.geometry.size;
  const auto usable = filledBlock(size, [&](std::size_t v) { return isUsable(stack, voxels, v); });
  Reach reach;
  for (int a = 0; a < 3; ++a) {
    const double first = usable ? static_cast<double>(usable->first[a]) : static_cast<double>(size[a]),
                 last = usable ? static_cast<double>(usable->first[a] + usable->size[a] - 1) : -1;
    reach.low[a] = std::max(-0.5, first - 1);
    reach.high[a] = std::min(static_cast<double>(size[a]) - 0.5, last + 1);
  }
  return reach;
}

/// Trilinear over the finite observed corners only.
Coverage sampleObserved(const Stack& stack, Voxels voxels, const Reach& reach, const Vec3& index,
                        double& value) {
  const auto& size = stack.image.geometry.size;
  const auto usable = [&](std::size_t v) { return isUsable(stack, voxels, v); };
  std::int64_t base[3], nearest[3];
  double fraction[3];
  for (int a = 0; a < 3; ++a) {
    if (index[a] < reach.low[a] || index[a] > reach.high[a]) return Coverage::Not;
    const double x = std::clamp(index[a], 0.0, static_cast<double>(size[a] - 1));
    nearest[a] = std::llround(x);
    base[a] = std::min<std::int64_t>(static_cast<std::int64_t>(x), std::max<std::int64_t>(size[a] - 2, 0));
    fraction[a] = x - static_cast<double>(base[a]);
  }
  double sum = 0, total = 0;
  for (int c = 0; c < 8; ++c) {
    const int dx = c & 1, dy = (c >> 1) & 1, dz = c >> 2;
    const double w = (dx ? fraction[0] : 1 - fraction[0]) * (dy ? fraction[1] : 1 - fraction[1]) *
                     (dz ? fraction[2] : 1 - fraction[2]);
    if (w <= 0) continue;
    const std::size_t v = (base[0] + dx) + size[0] * ((base[1] + dy) + size[1] * (base[2] + dz));
    if (!usable(v)) continue;
    sum += w * stack.image.voxels[v];
    total += w;
  }
  if (total <= 0) return Coverage::Not;
  value = sum / total;
  return usable(nearest[0] + size[0] * (nearest[1] + size[1] * nearest[2])) ? Coverage::Within
                                                                            : Coverage::Beside;
}

/// The posed slices whose tent of one slice spacing reaches the line between two points.
void findNear(std::span<const Affine3> toIndex, const Reach& reach, const Vec3& first, const Vec3& last,
              std::vector<std::size_t>& near) {
  constexpr double kReach = 1 + 1e-6;
  near.clear();
  for (std::size_t k = 0; k < toIndex.size(); ++k) {
    const auto slice = static_cast<double>(k);
    if (slice < reach.low[2] || slice > reach.high[2]) continue;
    const auto distance = [&](const Vec3& point) {
      return dot(toIndex[k].linear[2], point) + toIndex[k].offset[2] - static_cast<double>(k);
    };
    const double a = distance(first), b = distance(last);
    if (std::max(a, b) > -kReach && std::min(a, b) < kReach) near.push_back(k);
  }
}

/// Interpolates between the slices of a posed stack around a point, each weighted by a tent that extends one
/// slice spacing to either side. near: all that may reach the point.
Coverage samplePosed(const Stack& stack, Voxels voxels, const Reach& reach, std::span<const Affine3> toIndex,
                     std::span<const std::size_t> near, const Vec3& point, double& value) {
  double sum = 0, total = 0;
  Coverage most = Coverage::Not;
  for (const std::size_t k : near) {
    const Affine3& map = toIndex[k];
    const double z = dot(map.linear[2], point) + map.offset[2];
    const double w = 1 - std::abs(z - static_cast<double>(k));
    double slice;
    if (w <= 0) continue;
    const Vec3 index = map(point);
    const Coverage seen =
        sampleObserved(stack, voxels, reach, {index[0], index[1], static_cast<double>(k)}, slice);
    if (seen == Coverage::Not) continue;
    most = std::max(most, seen);
    sum += w * slice;
    total += w;
  }
  if (total < 0.1) return Coverage::Not;
  value = sum / total;
  return most;
}

} // namespace

ProxyVolume makeProxy(std::span<const Stack> stacks, const Affine3& modelToWorld, const IntensityMap& map,
                      double spacing, ThreadPool& pool, Voxels voxels) {
  const Bounds bounds = boundsOf(stacks, inverse(modelToWorld));
  ProxyVolume proxy;
  for (int a = 0; a < 3; ++a) {
    const double extent = bounds.high[a] - bounds.low[a];
    proxy.geometry.size[a] = std::max<std::int64_t>(1, std::llround(extent / spacing));
    proxy.geometry.spacing[a] = extent / static_cast<double>(proxy.geometry.size[a]);
    proxy.geometry.origin[a] = bounds.low[a] + 0.5 * proxy.geometry.spacing[a];
  }
  const auto& size = proxy.geometry.size;
  proxy.voxels.assign(proxy.geometry.voxelCount(), 0.f);
  proxy.covered.assign(proxy.voxels.size(), 0);
  std::vector<std::vector<Affine3>> toIndex; // model → stack index: one map, or one per slice with a pose
  std::vector<Reach> reach;
  for (const Stack& stack : stacks) {
    reach.push_back(reachOf(stack, voxels));
    const Affine3 map = stack.image.geometry.indexToWorld();
    auto& maps = toIndex.emplace_back();
    for (const Affine3& pose : stack.poses)
      maps.push_back(inverse(pose * map) * modelToWorld);
    if (stack.poses.empty()) maps.push_back(inverse(map) * modelToWorld);
  }
  const auto pointAt = [&](std::int64_t i, std::int64_t j, std::int64_t k) {
    Vec3 p;
    const std::int64_t index[3] = {i, j, k};
    for (int a = 0; a < 3; ++a)
      p[a] = proxy.geometry.origin[a] + proxy.geometry.spacing[a] * static_cast<double>(index[a]);
    return p;
  };
  pool.run(size[2], [&](std::int64_t k) {
    std::vector<std::vector<std::size_t>> near(stacks.size()); // posed slices around the row
    for (std::int64_t j = 0; j < size[1]; ++j) {
      for (std::size_t s = 0; s < stacks.size(); ++s)
        if (!stacks[s].poses.empty())
          findNear(toIndex[s], reach[s], pointAt(0, j, k), pointAt(size[0] - 1, j, k), near[s]);
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const Vec3 p = pointAt(i, j, k);
        double sum = 0;
        int n = 0;
        Coverage most = Coverage::Not;
        for (std::size_t s = 0; s < stacks.size(); ++s) {
          double value;
          const Coverage seen = stacks[s].poses.empty()
                                    ? sampleObserved(stacks[s], voxels, reach[s], toIndex[s][0](p), value)
                                    : samplePosed(stacks[s], voxels, reach[s], toIndex[s], near[s], p, value);
          if (seen == Coverage::Not) continue;
          most = std::max(most, seen);
          sum += value;
          ++n;
        }
        if (!n) continue;
        const std::size_t v = i + size[0] * (j + size[1] * k);
        proxy.voxels[v] = static_cast<float>((sum / n - map.offset) / map.scale);
        proxy.covered[v] = static_cast<std::uint8_t>(most);
      }
    }
  });
  // A mask of one or two voxels may fall between the points of the grid; those beside it then stand for
  // it.
  constexpr auto within = static_cast<std::uint8_t>(Coverage::Within);
  const bool any = std::find(proxy.covered.begin(), proxy.covered.end(), within) != proxy.covered.end();
  for (std::uint8_t& covered : proxy.covered)
    covered = any ? covered == within : covered != 0;
  return proxy;
}

} // namespace innergs
