#pragma once
#include "Core/Image/Volume.h"

#include <span>

namespace innergs {

/// How a slice averages the tissue along its normal.
enum class SliceProfile {
  Point,   // infinitely thin: a sample of the field
  Box,     // constant over the slice thickness (an average of thin slices)
  Gaussian // Gaussian with FWHM = slice thickness (τ = thickness / kFwhm)
};
constexpr double kFwhm = 2.3548200450309493; // of a Gaussian, in units of its σ

/// One acquisition: parallel slices (counted by the K axis) and their thickness.
struct Stack {
  Volume image;         // non-finite voxels are allowed and excluded from the fit
  double thickness = 0; // mm along K's direction; 0 = the slice spacing
  SliceProfile profile = SliceProfile::Box;
  double pixelWidth = 0; // mm along I and J that a pixel averages, as the profile (thin: a box); 0 = a point
  std::vector<std::uint8_t> observed; // per voxel, 0 = held out or outside the mask; empty = all observed
  std::vector<Affine3> poses; // per slice: rigid map (LPS mm) applied after indexToWorld; empty = identity
  std::vector<double> times;  // per slice, seconds; empty = static
  bool isRegion = false;      // a box cut out of a larger scan
  std::string name;           // for messages and reports (file name)
  std::string thicknessFrom;  // for reports: where the thickness is said
  std::vector<std::string> remarks; // sentences for the user on how the file was read
};

/// Whether a voxel, by its place in memory, is observed and finite.
bool isKnown(const Stack& stack, std::size_t voxel);
/// The stack's image, NaN where it is not observed.
Volume observedImage(const Stack& stack);

/// The same voxels as thin slices along grid axis 0, 1 or 2 (2: the stack itself), as thick as the spacing
/// there; `observed` is kept. Drops poses and times.
Stack withSliceAxis(const Stack& stack, int axis);

/// Range of the finite observed voxels of all stacks, outliers included. Throws Error(NoData) if there are
/// none.
ValueRange observedRange(std::span<const Stack> stacks);

/// Throws Error(InvalidArgument) for a slice thickness (mm) that is negative, not finite or more than 16
/// times the slice distance: overlapping slices are common, but this much is a mistake. 0: the slice distance
/// itself. Slices with poses may overlap by any amount, as images of a freely moved probe do: posed.
void checkThickness(double thickness, const GridGeometry& geometry, const std::string& what,
                    bool posed = false);

/// Checks sizes, geometry and that poses are rigid. Throws Error(Geometry | InvalidArgument | NoData).
void checkStack(const Stack& stack);

} // namespace innergs
