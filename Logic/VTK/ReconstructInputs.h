#pragma once
#include "Core/Job/ReconstructionJob.h"
#include "Geometry.h"

#include "vtkSmartPointer.h"

#include <stop_token>

class vtkInformation;

/// What vtkInnerGSReconstruct makes of its images: the engine's input.
namespace innergs::vtk {

/// The grid to put the result on, and the part of space that counts.
struct OutputChoice {
  const ReferenceGrid* reference = nullptr;
  Vec3 spacing{0, 0, 0};           // mm; 0 = the engine's choice
  std::optional<GridGeometry> box; // a lattice of one voxel (LPS): only its cell counts
};

/// The box of bounds (xmin, xmax, ...) in a frame that the matrix maps to RAS (null: RAS itself). Throws
/// Error(InvalidArgument) when they are not finite or inverted, Error(Geometry) for a matrix that shears.
GridGeometry boxOf(const double bounds[6], vtkMatrix4x4* toRAS);

class ReconstructInputs {
public:
  struct Input {
    vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // null: the image's own
    double thickness = 0;                   // mm
    int profile = 1, axis = 2;
    std::string name;
  };
  vtkSmartPointer<vtkMatrix4x4> maskToRAS;

  /// The index-th, made when new; null for a negative index.
  Input* at(int index);
  Input get(int index) const;

  /// Everything copied and checked. Throws Error.
  ReconstructionInput read(const std::vector<vtkImageData*>& images, vtkImageData* mask,
                           const OutputChoice& choice, const std::stop_token& stop) const;
  /// The same without voxels and mask: geometry, thickness and output grid.
  ReconstructionInput outline(const std::vector<vtkImageData*>& images, const OutputChoice& choice) const;

private:
  std::string what(std::size_t index) const;
  static void check(const Input& options, const std::string& name);
  ReconstructionInput make(const std::vector<vtkImageData*>& images, const OutputChoice& choice, bool voxels,
                           const std::stop_token& stop) const;
  std::vector<Input> inputs_;
};

/// Copies a matrix, or none; whether that changed anything.
bool assignCopy(vtkSmartPointer<vtkMatrix4x4>& target, vtkMatrix4x4* source);
/// Extent, origin, spacing and direction that a pipeline's information announces; no voxels.
void placeAsAnnounced(vtkInformation* information, vtkImageData* image);

} // namespace innergs::vtk
