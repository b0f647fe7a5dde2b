#pragma once
#include "Core/Job/ReconstructionJob.h"
#include "Geometry.h"

#include "vtkDoubleArray.h"
#include "vtkSmartPointer.h"

#include <stop_token>

class vtkInformation;

/// Converts the images of vtkInnerGSReconstruct to the engine's input.
namespace innergs::vtk {

/// The grid for the result, and the part of space that counts.
struct OutputChoice {
  const ReferenceGrid* reference = nullptr;
  Vec3 spacing{0, 0, 0};           // mm; 0 = the engine's choice
  std::optional<GridGeometry> box; // a grid of one voxel (LPS): only its cell is used
};

/// The box of bounds (xmin, xmax, ...) in a frame that the matrix maps to RAS (null: RAS itself). Throws
/// Error(InvalidArgument) if they are not finite or inverted, Error(Geometry) for a matrix with shear.
GridGeometry boxOf(const double bounds[6], vtkMatrix4x4* toRAS);

class ReconstructInputs {
public:
  struct Input {
    vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // null: the image's own
    vtkSmartPointer<vtkDoubleArray> poses;  // null: none
    double thickness = 0;                   // mm
    int profile = 1, axis = 2;
    std::string name;
  };
  std::vector<vtkSmartPointer<vtkMatrix4x4>> masksToRAS; // null or missing: the mask's own

  /// The index-th input, created on demand; null for a negative index.
  Input* at(int index);
  Input get(int index) const;

  /// Copies and checks everything. Throws Error.
  ReconstructionInput read(const std::vector<vtkImageData*>& images, const std::vector<vtkImageData*>& masks,
                           const OutputChoice& choice, const std::stop_token& stop) const;
  /// Likewise without voxels and masks: geometry, thickness and output grid.
  ReconstructionInput outline(const std::vector<vtkImageData*>& images, const OutputChoice& choice) const;

private:
  std::string what(std::size_t index) const;
  static void check(const Input& options, const std::string& name);
  ReconstructionInput make(const std::vector<vtkImageData*>& images, const OutputChoice& choice, bool voxels,
                           const std::stop_token& stop) const;
  std::vector<Input> inputs_;
};

/// Copies a matrix, or null; returns whether anything changed.
bool assignCopy(vtkSmartPointer<vtkMatrix4x4>& target, vtkMatrix4x4* source);
/// Sets extent, origin, spacing and direction as announced in a pipeline's information; no voxels.
void placeAsAnnounced(vtkInformation* information, vtkImageData* image);

} // namespace innergs::vtk
