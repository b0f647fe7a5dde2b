#include "Core/Image/Support.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Core/Image/Region.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

/// The smallest block that holds both.
IndexBlock joined(const IndexBlock& a, const IndexBlock& b) {
  IndexBlock both;
  for (int axis = 0; axis < 3; ++axis) {
    both.first[axis] = std::min(a.first[axis], b.first[axis]);
    both.size[axis] = std::max(a.first[axis] + a.size[axis], b.first[axis] + b.size[axis]) - both.first[axis];
  }
  return both;
}

/// The largest distance (mm) between the centre of a stack's voxel and that of the domain's voxel that holds
/// it.
double misplacement(const Stack& stack, const GridGeometry& domain) {
  const Affine3 map = inverse(domain.indexToWorld()) * stack.image.geometry.indexToWorld();
  const auto whole = [](double x) { return std::abs(x - std::round(x)) < 1e-3; };
  double squared = 0;
  for (int a = 0; a < 3; ++a) {
    const auto& row = map.linear[a];
    const bool onCentres =
        stack.poses.empty() && whole(row[0]) && whole(row[1]) && whole(row[2]) && whole(map.offset[a]);
    squared += onCentres ? 0 : domain.spacing[a] * domain.spacing[a] / 4;
  }
  return std::sqrt(squared);
}

/// Marks the voxels that contain the centre of an observed voxel.
void addObserved(Mask& marked, const Stack& stack) {
  const GridGeometry& g = stack.image.geometry;
  const Affine3 toMarked = inverse(marked.geometry.indexToWorld());
  const auto& n = marked.geometry.size;
  const std::uint8_t* observed = stack.observed.data();
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    const Affine3 map =
        toMarked * (stack.poses.empty() ? g.indexToWorld() : stack.poses[k] * g.indexToWorld());
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i, ++observed) {
        if (!*observed) continue;
        const Vec3 x = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        std::int64_t at = 0, stride = 1;
        for (int a = 0; a < 3 && at >= 0; ++a) {
          const std::int64_t nearest = std::llround(x[a]);
          at = nearest >= 0 && nearest < n[a] ? at + stride * nearest : -1;
          stride *= n[a];
        }
        if (at >= 0) marked.voxels[static_cast<std::size_t>(at)] = 1;
      }
  }
}

/// Marks the voxels whose centres lie within `margin` mm of a marked one's, by squared distances along one
/// axis after the other.
void dilate(Mask& mask, double margin, const std::stop_token& stop) {
  constexpr float kFar = std::numeric_limits<float>::infinity();
  const auto& n = mask.geometry.size;
  const float limit = static_cast<float>(margin * margin * (1 + 1e-6));
  std::vector<float> distance(mask.voxels.size()), reached;
  std::transform(mask.voxels.begin(), mask.voxels.end(), distance.begin(),
                 [](std::uint8_t v) { return v ? 0 : kFar; });
  const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
  for (int axis = 0; axis < 3; ++axis) {
    const double spacing = mask.geometry.spacing[axis];
    const auto reach =
        std::min<std::int64_t>(n[axis] - 1, static_cast<std::int64_t>(margin / spacing + 1e-6));
    reached = distance;
    for (std::int64_t step = 1; step <= reach; ++step) {
      throwIfStopped(stop);
      const auto add = static_cast<float>(spacing * spacing * static_cast<double>(step * step));
      const std::int64_t far = step * stride[axis], line = n[axis] * stride[axis];
      // Along the axis, voxels `step` apart are `far` apart in memory.
      for (std::int64_t begin = 0; begin < static_cast<std::int64_t>(distance.size()); begin += line)
        for (std::int64_t v = begin; v < begin + line - far; ++v) {
          reached[v] = std::min(reached[v], distance[v + far] + add);
          reached[v + far] = std::min(reached[v + far], distance[v] + add);
        }
    }
    distance.swap(reached);
  }
  std::transform(distance.begin(), distance.end(), mask.voxels.begin(),
                 [&](float d) { return static_cast<std::uint8_t>(d <= limit); });
}

} // namespace

double supportMargin(std::span<const Stack> stacks) {
  double margin = 0;
  for (const Stack& stack : stacks)
    margin = std::max(margin, stack.image.geometry.spacing[2]);
  return margin;
}

Mask supportOf(std::span<const Mask> masks, std::span<const Stack> stacks, const GridGeometry& domain,
               double margin, const std::stop_token& stop) {
  const auto none = [] {
    return Error(ErrorCode::NoData, "The mask does not overlap the images: check that it belongs to them.");
  };
  const double voxel = *std::max_element(domain.spacing.begin(), domain.spacing.end());
  std::optional<IndexBlock> block;
  for (const Mask& mask : masks)
    if (const auto inside = filledBlock(mask.geometry.size, mask.voxels)) {
      const GridGeometry box = boxOf(cropped(mask.geometry, inside->first, inside->size));
      if (const auto part = blockOver(domain, grown(box, margin + voxel)))
        block = block ? joined(*block, *part) : *part;
    }
  if (!block) throw none();
  throwIfStopped(stop);
  Mask support{cropped(domain, block->first, block->size), {}};
  support.voxels.resize(static_cast<std::size_t>(support.geometry.voxelCount()));
  double reach = margin; // both the sample and the queried point may lie off their voxel's centre
  for (const Stack& stack : stacks) {
    if (stack.observed.empty()) continue;
    addObserved(support, stack);
    reach = std::min(reach, margin - 2 * misplacement(stack, domain));
  }
  if (reach > 0) dilate(support, reach, stop);
  for (const Mask& mask : masks) {
    const std::vector<std::uint8_t> masked = resampleMask(mask, support.geometry, stop);
    for (std::size_t v = 0; v < masked.size(); ++v)
      support.voxels[v] |= masked[v];
  }
  const auto filled = filledBlock(support.geometry.size, support.voxels);
  if (!filled) throw none();
  return cropped(support, *filled);
}

} // namespace innergs
