#include "Core/Image/GridGeometry.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <limits>

namespace innergs {

Vec3 GridGeometry::centre() const {
  return indexToWorld()({0.5 * (size[0] - 1), 0.5 * (size[1] - 1), 0.5 * (size[2] - 1)});
}

double GridGeometry::finestSpacing() const {
  return std::min({spacing[0], spacing[1], spacing[2]});
}

Vec3 GridGeometry::extent() const {
  return {size[0] * spacing[0], size[1] * spacing[1], size[2] * spacing[2]};
}

std::array<Vec3, 8> GridGeometry::corners() const {
  const Affine3 map = indexToWorld();
  std::array<Vec3, 8> corners;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int a = 0; a < 3; ++a)
      index[a] = (corner >> a & 1) ? static_cast<double>(size[a]) - 0.5 : -0.5;
    corners[corner] = map(index);
  }
  return corners;
}

void checkGeometry(const GridGeometry& geometry, const std::string& what) {
  const auto fail = [&](const std::string& sentence) { throw Error(ErrorCode::Geometry, what + sentence); };
  std::int64_t count = 1;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t n = geometry.size[axis];
    if (n <= 0)
      fail(" has no voxels along axis " + std::string(1, "IJK"[axis]) + ": give an image with at least one.");
    if (n > std::numeric_limits<std::int64_t>::max() / 64 / count)
      fail(" has a size that no machine can hold: check its header.");
    count *= n;
  }
  for (double s : geometry.spacing)
    if (!std::isfinite(s) || s <= 0)
      fail(formatted(
          " has a voxel spacing of %g mm: spacings must be finite and above zero, correct its header.", s));
  for (double x : geometry.origin)
    if (!std::isfinite(x)) fail(" has an origin that is not finite: correct its header.");
  const Mat3 gram = transpose(geometry.direction) * geometry.direction;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] - (i == j)) <= 1e-3)) {
        const double det = determinant(geometry.direction);
        if (!std::isfinite(det)) fail(" has axis directions that are not finite: correct its header.");
        if (std::abs(det) < 1e-3)
          fail(" has a singular direction matrix (two axes point the same way): correct its header.");
        fail(" has axes that are not perpendicular unit vectors (a sheared or scaled direction matrix): "
             "resample "
             "it onto a rectangular grid first.");
      }
}

GridGeometry withSpacing(const GridGeometry& geometry, const Vec3& spacing) {
  if (spacing == geometry.spacing) return geometry; // keeps every bit
  GridGeometry result = geometry;
  result.spacing = spacing;
  const Vec3 extent = geometry.extent();
  for (int axis = 0; axis < 3; ++axis) {
    if (!std::isfinite(spacing[axis]) || spacing[axis] <= 0)
      throw Error(ErrorCode::InvalidArgument, "The voxel spacing must be above 0 mm along every axis.");
    if (extent[axis] / spacing[axis] > 1e5)
      throw Error(ErrorCode::InvalidArgument,
                  "The voxel spacing is far too fine for the size of the image: choose a coarser one.");
    result.size[axis] = std::max<std::int64_t>(1, std::llround(extent[axis] / spacing[axis]));
  }
  result.origin = {0, 0, 0};
  result.origin = geometry.centre() - result.centre();
  return result;
}

GridGeometry reduced(const GridGeometry& geometry, std::int64_t most) {
  Vec3 spacing = geometry.spacing;
  for (int a = 0; a < 3; ++a)
    spacing[a] *= std::max(1.0, static_cast<double>(geometry.size[a]) / static_cast<double>(most));
  return withSpacing(geometry, spacing);
}

GridGeometry cropped(const GridGeometry& geometry, const std::array<std::int64_t, 3>& first,
                     const std::array<std::int64_t, 3>& size) {
  for (int axis = 0; axis < 3; ++axis)
    if (first[axis] < 0 || size[axis] <= 0 || first[axis] > geometry.size[axis] - size[axis])
      throw Error(ErrorCode::InvalidArgument,
                  "The region does not lie inside the image: give a smaller one.");
  GridGeometry result = geometry;
  result.size = size;
  result.origin = geometry.indexToWorld()({double(first[0]), double(first[1]), double(first[2])});
  return result;
}

double depthInside(const GridGeometry& geometry, const Vec3& index) {
  double least = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double low = index[a] + 0.5, high = static_cast<double>(geometry.size[a]) - low;
    least = std::min(least, std::min(low, high) * geometry.spacing[a]);
  }
  return least;
}

bool sameGrid(const GridGeometry& a, const GridGeometry& b, double tolerance) {
  if (a.size != b.size) return false;
  const Affine3 worldOfA = a.indexToWorld(), worldOfB = b.indexToWorld();
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index;
    for (int axis = 0; axis < 3; ++axis)
      index[axis] = (corner >> axis & 1) ? double(a.size[axis] - 1) : 0.0;
    if (!(norm(worldOfA(index) - worldOfB(index)) <= tolerance)) return false;
  }
  return true;
}

} // namespace innergs
