#pragma once
#include "Core/Image/GridGeometry.h"

#include "vtkMatrix4x4.h"
#include "vtkNew.h"

#include <string>

class vtkImageData;

/// Between VTK's world (RAS, mm) and the engine's (LPS, mm). The only place where the one is turned into the
/// other.
namespace innergs::vtk {

/// LPS of a RAS point, and RAS of an LPS point.
inline Vec3 flipped(const Vec3& x) {
  return {-x[0], -x[1], x[2]};
}
/// F·a with F = diag(−1, −1, 1): a map to LPS from one to RAS, and back.
inline Affine3 flipped(const Affine3& a) {
  return {diagonal({-1, -1, 1}) * a.linear, flipped(a.offset)};
}

/// The map of a matrix as it stands. Throws Error(Geometry) when it is null, not affine, not finite or not
/// invertible; `what` names it in the sentence.
Affine3 affineOf(vtkMatrix4x4* matrix, const std::string& what);
void toMatrix(const Affine3& map, vtkMatrix4x4* matrix);

/// The LPS lattice of dimensions[3] voxels whose structured coordinates begin at `first`. Throws
/// Error(Geometry) as affineOf and checkGeometry do.
GridGeometry gridOf(vtkMatrix4x4* ijkToRAS, const int dimensions[3], const int first[3],
                    const std::string& what);
/// The same for an image; ijkToRAS null: from its origin, spacing and direction (RAS).
GridGeometry gridOf(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const std::string& what);

/// The IJK→RAS matrix of a lattice.
void toMatrix(const GridGeometry& geometry, vtkMatrix4x4* ijkToRAS);
/// Origin, spacing and direction (RAS) of an image on the lattice; without geometry: 0, 1 and the identity.
void placeImage(vtkImageData* image, const GridGeometry& geometry, bool withGeometry);

/// A grid to put a result on, kept as it was given and checked when used.
class ReferenceGrid {
public:
  /// Copies; null: none. Whether anything changed.
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
