#include "Core/Image/Region.h"

#include "Core/Base/Error.h"
#include "Core/Image/Bounds.h"

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
                  "The region of interest is empty: give xmin,xmax,ymin,ymax,zmin,zmax in mm, each "
                  "minimum below its maximum.");
}

using Corners = std::array<Vec3, 8>;

Corners cornersOf(const Region& region, double margin) {
  Corners corners;
  for (int corner = 0; corner < 8; ++corner)
    for (int a = 0; a < 3; ++a)
      corners[corner][a] = corner >> a & 1 ? region.max[a] + margin : region.min[a] - margin;
  return corners;
}

Corners cornersOf(const GridGeometry& box, double margin) {
  return grown(box, margin).corners();
}

// The voxels whose cells touch the box, on a grid given by indexToWorld.
IndexBox covering(const Affine3& indexToWorld, const std::array<std::int64_t, 3>& size,
                  const Corners& corners) {
  constexpr double rounding = 1e-6; // voxels: a box face on a voxel face must not include a neighbour by
                                    // rounding
  const Affine3 worldToIndex = inverse(indexToWorld);
  Bounds bounds; // voxels
  for (const Vec3& corner : corners)
    bounds.include(worldToIndex(corner));
  IndexBox box;
  for (int a = 0; a < 3; ++a) {
    const double n = static_cast<double>(size[a]);
    box.first[a] = static_cast<std::int64_t>(std::clamp(std::floor(bounds.low[a] + 0.5 + rounding), 0.0, n));
    box.last[a] =
        static_cast<std::int64_t>(std::clamp(std::ceil(bounds.high[a] - 0.5 - rounding), -1.0, n - 1));
  }
  return box;
}

[[noreturn]] void doNotMeet(const std::string& what) {
  throw Error(ErrorCode::Geometry, "The region of interest lies outside " + what +
                                       ": give it in mm in patient space, LPS (x to the left, y to the back, "
                                       "z to the head) unless RAS was "
                                       "asked for.");
}

std::optional<IndexBlock> blockOver(const GridGeometry& geometry, const Corners& corners) {
  const IndexBox box = covering(geometry.indexToWorld(), geometry.size, corners);
  if (box.empty()) return {};
  IndexBlock block{box.first, {}};
  for (int a = 0; a < 3; ++a)
    block.size[a] = box.last[a] - box.first[a] + 1;
  return block;
}

GridGeometry blockOf(const GridGeometry& geometry, const Corners& corners) {
  const auto block = blockOver(geometry, corners);
  if (!block) doNotMeet("the image");
  return cropped(geometry, block->first, block->size);
}

template <class Image>
Image partOf(const Image& image, const IndexBlock& block) {
  Image part{cropped(image.geometry, block.first, block.size), {}};
  const auto& n = image.geometry.size;
  part.voxels.reserve(static_cast<std::size_t>(part.geometry.voxelCount()));
  for (std::int64_t k = 0; k < block.size[2]; ++k)
    for (std::int64_t j = 0; j < block.size[1]; ++j) {
      const auto row =
          image.voxels.begin() + block.first[0] + n[0] * (block.first[1] + j + n[1] * (block.first[2] + k));
      part.voxels.insert(part.voxels.end(), row, row + block.size[0]);
    }
  return part;
}

} // namespace

GridGeometry boxOf(const Region& region) {
  checkRegion(region);
  GridGeometry box;
  box.size = {1, 1, 1};
  box.origin = 0.5 * (region.min + region.max);
  box.spacing = region.max - region.min;
  return box;
}

GridGeometry boxOf(const GridGeometry& grid) {
  return {{1, 1, 1}, grid.centre(), grid.extent(), grid.direction};
}

std::optional<IndexBlock> blockOver(const GridGeometry& geometry, const GridGeometry& box) {
  return blockOver(geometry, cornersOf(box, 0));
}

std::optional<IndexBlock> filledBlock(const std::array<std::int64_t, 3>& size,
                                      std::span<const std::uint8_t> voxels) {
  return filledBlock(size, [&](std::size_t v) { return voxels[v] != 0; });
}

Volume cropped(const Volume& volume, const IndexBlock& block) {
  return partOf(volume, block);
}

Mask cropped(const Mask& mask, const IndexBlock& block) {
  return partOf(mask, block);
}

GridGeometry grown(const GridGeometry& box, double margin) {
  GridGeometry result = box;
  for (double& side : result.spacing)
    side += 2 * margin;
  return result;
}

bool parallel(const GridGeometry& geometry, const GridGeometry& box) {
  const Mat3 cosines = transpose(geometry.direction) * box.direction;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      if (const double x = std::abs(cosines[r][c]); x > 1e-4 && x < 1 - 1e-4) return false;
  return true;
}

GridGeometry cropped(const GridGeometry& geometry, const Region& region, double margin) {
  checkRegion(region);
  return blockOf(geometry, cornersOf(region, margin));
}

GridGeometry cropped(const GridGeometry& geometry, const GridGeometry& box, double margin) {
  checkGeometry(box, "The region of interest");
  return blockOf(geometry, cornersOf(box, margin));
}

Stack cropped(const Stack& stack, const Region& region, double margin) {
  checkRegion(region);
  const GridGeometry& from = stack.image.geometry;
  IndexBox box{from.size, {-1, -1, -1}};
  for (std::int64_t k = 0; k < from.size[2]; ++k) {
    const Affine3 placed = stack.poses.empty() ? from.indexToWorld() : stack.poses[k] * from.indexToWorld();
    const IndexBox slice = covering(placed, from.size, cornersOf(region, margin));
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
  part.pixelWidth = stack.pixelWidth;
  part.isRegion = stack.isRegion || size != from.size;
  part.name = stack.name;
  part.thicknessFrom = stack.thicknessFrom;
  part.remarks = stack.remarks;
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
