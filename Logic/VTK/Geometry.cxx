#include "Geometry.h"

#include "Core/Base/Error.h"

#include "vtkImageData.h"

#include <cmath>

namespace innergs::vtk {

Affine3 affineOf(vtkMatrix4x4* matrix, const std::string& what) {
  const auto fail = [&](const char* sentence) { throw Error(ErrorCode::Geometry, what + sentence); };
  if (!matrix) fail(" is missing: give a 4x4 matrix to RAS.");
  Affine3 map;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      const double x = matrix->GetElement(i, j);
      if (!std::isfinite(x)) fail(" has an element that is not finite: correct it.");
      if (i == 3 && std::abs(x - (j == 3)) > 1e-9)
        fail(" is a projection: its last row must be 0 0 0 1, harden or leave out non-linear transforms.");
      if (i < 3) (j < 3 ? map.linear[i][j] : map.offset[i]) = x;
    }
  const double scale =
      norm(column(map.linear, 0)) * norm(column(map.linear, 1)) * norm(column(map.linear, 2));
  if (!(std::abs(determinant(map.linear)) > 1e-9 * scale))
    fail(" cannot be inverted: two of its axes point the same way or one has no length, correct it.");
  return map;
}

void toMatrix(const Affine3& map, vtkMatrix4x4* matrix) {
  double elements[16] = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      elements[4 * i + j] = map.linear[i][j];
    elements[4 * i + 3] = map.offset[i];
  }
  matrix->DeepCopy(elements);
}

GridGeometry gridOf(vtkMatrix4x4* ijkToRAS, const int dimensions[3], const int first[3],
                    const std::string& what) {
  const Affine3 map = flipped(affineOf(ijkToRAS, "The IJK to RAS matrix of " + what));
  GridGeometry grid;
  for (int a = 0; a < 3; ++a) {
    const Vec3 axis = column(map.linear, a);
    grid.size[a] = dimensions[a];
    grid.spacing[a] = norm(axis);
    for (int i = 0; i < 3; ++i)
      grid.direction[i][a] = axis[i] / grid.spacing[a];
  }
  grid.origin = map({double(first[0]), double(first[1]), double(first[2])});
  checkGeometry(grid, what);
  return grid;
}

GridGeometry gridOf(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const std::string& what) {
  if (!image) throw Error(ErrorCode::NoData, what + " is missing: give an image.");
  int dimensions[3], extent[6];
  image->GetDimensions(dimensions);
  image->GetExtent(extent);
  const int first[3] = {extent[0], extent[2], extent[4]};
  return gridOf(ijkToRAS ? ijkToRAS : image->GetIndexToPhysicalMatrix(), dimensions, first, what);
}

void toMatrix(const GridGeometry& geometry, vtkMatrix4x4* ijkToRAS) {
  toMatrix(flipped(geometry.indexToWorld()), ijkToRAS);
}

void placeImage(vtkImageData* image, const GridGeometry& geometry, bool withGeometry) {
  double direction[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, origin[3] = {0, 0, 0}, spacing[3] = {1, 1, 1};
  if (withGeometry) {
    const Affine3 map = flipped(Affine3{geometry.direction, geometry.origin});
    for (int i = 0; i < 3; ++i) {
      origin[i] = map.offset[i];
      spacing[i] = geometry.spacing[i];
      for (int j = 0; j < 3; ++j)
        direction[3 * i + j] = map.linear[i][j];
    }
  }
  image->SetOrigin(origin);
  image->SetSpacing(spacing);
  image->SetDirectionMatrix(direction);
}

bool ReferenceGrid::set(vtkMatrix4x4* ijkToRAS, const int dimensions[3], const int first[3]) {
  const bool before = given_;
  given_ = ijkToRAS != nullptr;
  if (!given_) return before;
  bool same = before;
  for (int i = 0; same && i < 16; ++i)
    same = matrix_->GetElement(i / 4, i % 4) == ijkToRAS->GetElement(i / 4, i % 4);
  for (int a = 0; a < 3; ++a) {
    same = same && dimensions_[a] == dimensions[a] && first_[a] == first[a];
    dimensions_[a] = dimensions[a];
    first_[a] = first[a];
  }
  matrix_->DeepCopy(ijkToRAS);
  return !same;
}

bool ReferenceGrid::set(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  int dimensions[3] = {0, 0, 0}, extent[6] = {0, -1, 0, -1, 0, -1};
  if (image) {
    image->GetDimensions(dimensions);
    image->GetExtent(extent);
    if (!ijkToRAS) ijkToRAS = image->GetIndexToPhysicalMatrix();
  }
  const int first[3] = {extent[0], extent[2], extent[4]};
  return set(image ? ijkToRAS : nullptr, dimensions, first);
}

GridGeometry ReferenceGrid::grid() const {
  return gridOf(matrix_, dimensions_, first_, "The reference grid");
}

GridGeometry outputGrid(const GridGeometry& region, const ReferenceGrid& reference, const double spacing[3]) {
  if (reference.given()) return reference.grid();
  if (region.voxelCount() == 0)
    throw Error(
        ErrorCode::Geometry,
        "The model does not say which region it was fitted to: give a reference grid to resample it on.");
  if (spacing[0] == 0 && spacing[1] == 0 && spacing[2] == 0) return region;
  return withSpacing(region, {spacing[0], spacing[1], spacing[2]});
}

} // namespace innergs::vtk
