#pragma once
#include "Core/Image/GridGeometry.h"

#include "vtkMatrix4x4.h"
#include "vtkNew.h"

#include <string>

class vtkImageData;

/// Conversions between VTK's world (RAS, mm) and the engine's (LPS, mm). All of them are here.
namespace innergs::vtk {

/// RAS → LPS, and LPS → RAS.
inline Vec3 flipped(const Vec3& x) {
  return {-x[0], -x[1], x[2]};
}
/// F·a with F = diag(−1, −1, 1): turns a map to RAS into one to LPS, and back.
inline Affine3 flipped(const Affine3& a) {
  return {diagonal({-1, -1, 1}) * a.linear, flipped(a.offset)};
}

/// The map of a matrix, unchanged. Throws Error(Geometry) if it is null, not affine, not finite or not
/// invertible; `what` names it in the message.
Affine3 affineOf(vtkMatrix4x4* matrix, const std::string& what);
void toMatrix(const Affine3& map, vtkMatrix4x4* matrix);

/// The LPS grid of dimensions[3] voxels whose structured coordinates begin at `first`. Throws
/// Error(Geometry) like affineOf and checkGeometry.
GridGeometry gridOf(vtkMatrix4x4* ijkToRAS, const int dimensions[3], const int first[3],
                    const std::string& what);
/// Likewise for an image; ijkToRAS null: from its origin, spacing and direction (RAS).
GridGeometry gridOf(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const std::string& what);

/// The IJK→RAS matrix of a grid.
void toMatrix(const GridGeometry& geometry, vtkMatrix4x4* ijkToRAS);
/// Sets an image's origin, spacing and direction (RAS) to the grid's; without geometry: to 0, 1, identity.
void placeImage(vtkImageData* image, const GridGeometry& geometry, bool withGeometry);

/// A grid for the result, stored as given and checked on use.
class ReferenceGrid {
public:
  /// Copies; null: none. Returns whether anything changed.
  bool set(vtkMatrix4x4* ijkToRAS, const int dimensions[3], const int first[3]);
  bool set(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  bool given() const { return given_; }
  /// Throws Error(Geometry).
  GridGeometry grid() const;

private:
  bool given_ = false;
  vtkNew<vtkMatrix4x4> matrix_;
  int dimensions_[3] = {0, 0, 0}, first_[3] = {0, 0, 0};
};

/// The grid of a filter's output: the reference if one is given, else the region that a model was fitted to,
/// at another spacing (mm) unless it is 0, 0, 0. Throws Error(Geometry).
GridGeometry outputGrid(const GridGeometry& region, const ReferenceGrid& reference, const double spacing[3]);

} // namespace innergs::vtk
