#include "Core/Region.h"

#include "Core/Error.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

struct IndexBox {
  std::array<std::int64_t, 3> first, last; // inclusive; empty when last < first
  bool empty() const { return last[0] < first[0] || last[1] < first[1] || last[2] < first[2]; }
};

void checkRegion(const Region& region) {
  for (int a = 0; a < 3; ++a)
    if (!(region.min[a] < region.max[a]) || !std::isfinite(region.max[a] - region.min[a]))
      throw Error(ErrorCode::InvalidArgument,
                  "The region of interest is empty: give xmin,xmax,ymin,ymax,zmin,zmax in mm (LPS), "
                  "each minimum below its maximum.");
}

// Voxels whose cells touch the region, on a lattice placed by indexToWorld.
IndexBox covering(const Affine3& indexToWorld, const std::array<std::int64_t, 3>& size, const Region& region,
                  double margin) {
  const Affine3 worldToIndex = inverse(indexToWorld);
  Vec3 low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 p;
    for (int a = 0; a < 3; ++a)
      p[a] = corner >> a & 1 ? region.max[a] + margin : region.min[a] - margin;
    const Vec3 index = worldToIndex(p);
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], index[a]);
      high[a] = std::max(high[a], index[a]);
    }
  }
  IndexBox box;
  for (int a = 0; a < 3; ++a) {
    const double n = static_cast<double>(size[a]);
    box.first[a] = static_cast<std::int64_t>(std::clamp(std::floor(low[a] + 0.5), 0.0, n));
    box.last[a] = static_cast<std::int64_t>(std::clamp(std::ceil(high[a] - 0.5), -1.0, n - 1));
  }
  return box;
}

[[noreturn]] void doNotMeet(const std::string& what) {
  throw Error(ErrorCode::Geometry,
              "The region of interest lies outside " + what +
                  ": give it in mm in patient space (LPS: x to the left, y to the back, z to the head).");
}

} // namespace

GridGeometry cropped(const GridGeometry& geometry, const Region& region, double margin) {
  checkRegion(region);
  const IndexBox box = covering(geometry.indexToWorld(), geometry.size, region, margin);
  if (box.empty()) doNotMeet("the image");
  std::array<std::int64_t, 3> size;
  for (int a = 0; a < 3; ++a)
    size[a] = box.last[a] - box.first[a] + 1;
  return cropped(geometry, box.first, size);
}

Stack cropped(const Stack& stack, const Region& region, double margin) {
  checkRegion(region);
  const GridGeometry& from = stack.image.geometry;
  IndexBox box{from.size, {-1, -1, -1}};
  for (std::int64_t k = 0; k < from.size[2]; ++k) {
    const Affine3 placed = stack.poses.empty() ? from.indexToWorld() : stack.poses[k] * from.indexToWorld();
    const IndexBox slice = covering(placed, from.size, region, margin);
    if (slice.empty() || k < slice.first[2] || k > slice.last[2]) continue;
    for (int a = 0; a < 2; ++a) {
      box.first[a] = std::min(box.first[a], slice.first[a]);
      box.last[a] = std::max(box.last[a], slice.last[a]);
    }
    box.first[2] = std::min(box.first[2], k);
    box.last[2] = k;
  }
  if (box.empty()) doNotMeet(stack.name.empty() ? "the scan" : "'" + stack.name + "'");

  std::array<std::int64_t, 3> size;
  for (int a = 0; a < 3; ++a)
    size[a] = box.last[a] - box.first[a] + 1;
  Stack part;
  part.image.geometry = cropped(from, box.first, size);
  part.thickness = stack.thickness;
  part.profile = stack.profile;
  part.name = stack.name;
  part.image.voxels.reserve(part.image.geometry.voxelCount());
  for (std::int64_t k = box.first[2]; k <= box.last[2]; ++k)
    for (std::int64_t j = box.first[1]; j <= box.last[1]; ++j) {
      const std::int64_t begin = box.first[0] + from.size[0] * (j + from.size[1] * k);
      const auto copyRow = [&](const auto& source, auto& target) {
        target.insert(target.end(), source.begin() + begin, source.begin() + begin + size[0]);
      };
      copyRow(stack.image.voxels, part.image.voxels);
      if (!stack.observed.empty()) copyRow(stack.observed, part.observed);
    }
  const auto keepSlices = [&](const auto& source, auto& target) {
    if (!source.empty()) target.assign(source.begin() + box.first[2], source.begin() + box.last[2] + 1);
  };
  keepSlices(stack.poses, part.poses);
  keepSlices(stack.times, part.times);
  return part;
}

} // namespace innergs
