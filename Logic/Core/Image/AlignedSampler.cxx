#include "Core/Image/AlignedSampler.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr double kRounding = 1e-6; // of index maps, voxels

} // namespace

std::optional<std::array<int, 3>> parallelAxes(const std::array<std::int64_t, 3>& points,
                                               const Affine3& map) {
  std::array<int, 3> axes{};
  std::array<bool, 3> taken{};
  for (int b = 0; b < 3; ++b) {
    const Vec3 way = column(map.linear, b);
    int axis = 0;
    for (int a = 1; a < 3; ++a)
      if (std::abs(way[a]) > std::abs(way[axis])) axis = a;
    for (int a = 0; a < 3; ++a)
      if (a != axis && !(std::abs(way[a]) * static_cast<double>(points[b]) < 0.1 * kRounding)) return {};
    if (taken[axis]) return {};
    taken[axis] = true;
    axes[b] = axis;
  }
  return axes;
}

std::optional<AlignedSampler> AlignedSampler::between(const std::array<std::int64_t, 3>& points,
                                                      const Affine3& map, const GridGeometry& grid) {
  const auto axes = parallelAxes(points, map);
  if (!axes) return {};
  AlignedSampler sampler;
  for (int b = 0; b < 3; ++b) {
    const int axis = (*axes)[b];
    std::int64_t stride = 1;
    for (int a = 0; a < axis; ++a)
      stride *= grid.size[a];
    const auto last = static_cast<double>(grid.size[axis] - 1);
    sampler.along_[b].resize(static_cast<std::size_t>(points[b]));
    for (std::int64_t i = 0; i < points[b]; ++i) {
      double x = map.linear[axis][b] * static_cast<double>(i) + map.offset[axis];
      const double nearest = std::round(x);
      if (std::abs(x - nearest) < kRounding) x = nearest;
      Position& p = sampler.along_[b][i];
      p.inside = x >= -0.5 - kRounding && x <= last + 0.5 + kRounding;
      if (!p.inside) continue;
      x = std::clamp(x, 0.0, last);
      const auto low = static_cast<std::int64_t>(x);
      p.offset = low * stride;
      p.step = low < grid.size[axis] - 1 ? stride : 0;
      p.fraction = static_cast<float>(x - static_cast<double>(low));
    }
  }
  const std::vector<Position>& row = sampler.along_[0];
  const auto first = std::find_if(row.begin(), row.end(), [](const Position& p) { return p.inside; });
  const auto end = std::find_if(first, row.end(), [](const Position& p) { return !p.inside; });
  sampler.first_ = first - row.begin();
  sampler.end_ = end - row.begin();
  sampler.contiguous_ = first != end;
  for (auto p = first; p != end; ++p)
    sampler.contiguous_ = sampler.contiguous_ && p->fraction == 0 && p->offset == first->offset + (p - first);
  return sampler;
}

} // namespace innergs
