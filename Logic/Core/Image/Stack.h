#pragma once
#include "Core/Image/Volume.h"

#include <span>

namespace innergs {

/// How a slice weighs the tissue along its normal.
enum class SliceProfile {
  Point,   // infinitely thin: a sample of the field
  Box,     // constant over the slice thickness (an average of thin slices)
  Gaussian // Gaussian with FWHM = slice thickness (τ = thickness / 2.355)
};

/// One acquisition: parallel slices (the K axis counts them) with the thickness they were acquired with.
struct Stack {
  Volume image;         // non-finite voxels are allowed and left out of the fit
  double thickness = 0; // mm along K's direction; 0 = the slice spacing
  SliceProfile profile = SliceProfile::Box;
  std::vector<std::uint8_t> observed; // per voxel, 0 = withheld or outside the mask; empty = all observed
  std::vector<Affine3> poses; // per slice: rigid map (LPS mm) applied after indexToWorld; empty = identity
  std::vector<double> times;  // per slice, seconds; empty = static
  bool isRegion = false;      // a box cut out of a larger scan
  std::string name;           // for messages and reports (file name)
};

/// The same voxels as thin slices along lattice axis 0, 1 or 2 (2: the stack itself), each of the slice
/// spacing there; what is observed goes along. No poses or times.
Stack withSliceAxis(const Stack& stack, int axis);

/// Of the finite observed voxels of all stacks, none left out as an outlier. Throws Error(NoData) where there
/// is no such voxel.
ValueRange observedRange(std::span<const Stack> stacks);

/// Throws Error(InvalidArgument) for a slice thickness (mm) that is negative, not finite or more than 16
/// times the distance of the slices: overlapping slices are common, such ones are a slip. 0: the distance
/// itself.
void checkThickness(double thickness, const GridGeometry& geometry, const std::string& what);

/// Checks sizes, geometry and that poses are rigid; throws Error(Geometry | InvalidArgument | NoData).
void checkStack(const Stack& stack);

} // namespace innergs
