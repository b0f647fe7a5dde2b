#include "Core/Uncertainty/SimulatedGrids.h"

#include "Core/Image/Region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kEdge = 96;  // voxels of the cube
constexpr double kFewestSlices = 8; // of the thickest stack, in it
constexpr double kRounding = 1e-6;  // of grid indices

IndexBlock partIn(const GridGeometry& cube, const GridGeometry& g) {
  const Affine3 map = inverse(g.indexToWorld()) * cube.indexToWorld();
  IndexBlock part;
  auto& [first, size] = part;
  for (int a = 0; a < 3; ++a) {
    double low = std::numeric_limits<double>::max(), high = std::numeric_limits<double>::lowest();
    for (int corner = 0; corner < 8; ++corner) {
      Vec3 index;
      for (int b = 0; b < 3; ++b)
        index[b] = (corner >> b & 1) ? static_cast<double>(cube.size[b] - 1) : 0;
      low = std::min(low, map(index)[a]);
      high = std::max(high, map(index)[a]);
    }
    first[a] = std::clamp<std::int64_t>(std::llround(std::ceil(low - kRounding)), 0, g.size[a] - 1);
    size[a] = std::clamp<std::int64_t>(std::llround(std::floor(high + kRounding)), first[a], g.size[a] - 1) -
              first[a] + 1;
  }
  return part;
}

} // namespace

double coarsestSlices(std::span<const Stack> stacks) {
  double coarsest = 0;
  for (const Stack& stack : stacks)
    coarsest = std::max({coarsest, stack.image.geometry.spacing[2], stack.thickness});
  return coarsest;
}

GridGeometry simulationGrid(std::span<const Stack> stacks, const Vec3& middle) {
  double finest = std::numeric_limits<double>::max();
  for (const Stack& stack : stacks) {
    const Vec3& s = stack.image.geometry.spacing;
    finest = std::min({finest, s[0], s[1], s[2]});
  }
  const double spacing =
      std::max(finest, (kFewestSlices + 2) * coarsestSlices(stacks) / static_cast<double>(kEdge));
  GridGeometry grid;
  grid.direction = stacks.front().image.geometry.direction;
  grid.size = {kEdge, kEdge, kEdge};
  grid.spacing = {spacing, spacing, spacing};
  const double half = 0.5 * spacing * static_cast<double>(kEdge - 1);
  grid.origin = middle - grid.direction * Vec3{half, half, half};
  return grid;
}

std::vector<Stack> simulatedGrids(std::span<const Stack> stacks, const GridGeometry& grid, bool posed) {
  std::vector<Stack> parts;
  for (const Stack& stack : stacks) {
    Stack& part = parts.emplace_back();
    const IndexBlock block = partIn(grid, stack.image.geometry);
    part.image.geometry = cropped(stack.image.geometry, block.first, block.size);
    if (posed && !stack.poses.empty())
      part.poses.assign(stack.poses.begin() + block.first[2],
                        stack.poses.begin() + block.first[2] + block.size[2]);
    part.thickness = stack.thickness;
    part.profile = stack.profile;
    part.pixelWidth = stack.pixelWidth;
    part.name = stack.name;
  }
  return parts;
}

} // namespace innergs
