#include "Core/Alignment/SamplePlaces.h"

#include "Core/Image/Bounds.h"
#include "Core/Image/Otsu.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {

namespace {

/// The part of a grid with voxels that are seen; all of it where there are none.
template <typename Visible>
GridGeometry boxOf(const GridGeometry& g, const Visible& seen) {
  std::array<std::int64_t, 3> low = g.size, high{-1, -1, -1};
  for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
    if (!seen(v)) continue;
    const std::int64_t at[3] = {v % g.size[0], v / g.size[0] % g.size[1], v / (g.size[0] * g.size[1])};
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  }
  if (high[0] < 0) return g;
  return cropped(g, low, {high[0] - low[0] + 1, high[1] - low[1] + 1, high[2] - low[2] + 1});
}

} // namespace

GridGeometry gridAround(std::span<const GridGeometry> boxes, double spacing, double margin) {
  GridGeometry grid;
  grid.direction = boxes.front().direction;
  Bounds bounds; // along its axes
  for (const GridGeometry& g : boxes)
    for (const Vec3& corner : g.corners())
      bounds.include(transpose(grid.direction) * corner);
  for (int a = 0; a < 3; ++a) {
    const double extent = bounds.high[a] - bounds.low[a] + 2 * margin;
    grid.size[a] = static_cast<std::int64_t>(std::ceil(extent / spacing)) + 1;
    grid.spacing[a] = spacing;
  }
  grid.origin = grid.direction * (bounds.low - Vec3{margin, margin, margin});
  return grid;
}

std::vector<GridGeometry> observedBoxes(std::span<const Stack> stacks) {
  std::vector<GridGeometry> boxes;
  for (const Stack& stack : stacks)
    boxes.push_back(boxOf(stack.image.geometry, [&](std::int64_t v) { return isKnown(stack, v); }));
  return boxes;
}

GridGeometry observedBox(const BlurredStack& image) {
  return boxOf(image.geometry(), [&](std::int64_t v) { return !std::isnan(image.values()[v]); });
}

std::vector<Vec3> spreadPlaces(const GridGeometry& box, double distance) {
  constexpr double kMost = 40'000;
  double volume = 1;
  for (int a = 0; a < 3; ++a)
    volume *= static_cast<double>(box.size[a]) * box.spacing[a];
  const auto count =
      static_cast<std::int64_t>(std::clamp(volume / (distance * distance * distance), 1.0, kMost));
  constexpr double root = 1.2207440846057596; // x⁴ = x + 1
  const Affine3 map = box.indexToWorld();
  std::vector<Vec3> points;
  double step = 1, position[3];
  for (double& p : position)
    p = step /= root;
  for (std::int64_t n = 1; n <= count; ++n) {
    Vec3 index;
    for (int a = 0; a < 3; ++a)
      index[a] =
          std::fmod(0.5 + static_cast<double>(n) * position[a], 1.0) * static_cast<double>(box.size[a]) - 0.5;
    points.push_back(map(index));
  }
  return points;
}

ValueRange valuesOf(const BlurredStack& image) {
  ValueRange range{std::numeric_limits<float>::max(), std::numeric_limits<float>::lowest()};
  for (const float v : image.values())
    if (std::isfinite(v)) {
      range.low = std::min(range.low, v);
      range.high = std::max(range.high, v);
    }
  return range;
}

double bodyThreshold(const BlurredStack& image) {
  return 0.5 * (valuesOf(image).low + foregroundThreshold(image.values()));
}

bool belowZero(const ValueRange& range) {
  return range.low < -0.05f * (range.high - range.low);
}

} // namespace innergs
