#pragma once
#include "Core/Acquisition/ClosedFormPsf.h"
#include "Core/Acquisition/SampleGrid.h"
#include "Core/Image/Stack.h"

#include <array>

namespace innergs {

/// The map between scanner values and the field's intensities: value = scale·I + offset.
struct IntensityMap {
  double scale = 1, offset = 0;
};

/// Samples to fit on one grid: slices, each seen through one or several sub-planes (a quadrature of the
/// slice profile), and pixels through one or several points.
struct Observation {
  struct SubPlane {
    int plane;    // point · grid.planes() + plane of the grid
    float weight; // quadrature weight; sums to 1 per slice
  };
  SampleGrid grid;
  std::vector<std::array<double, 2>> points{{0, 0}}; // of a pixel, from its centre: pixels along I and J
  ClosedFormPsf psf;
  int slices = 0;
  std::vector<SubPlane> subPlanes; // of all points, grouped by slice: subPlanes[s·perSlice + q]
  int perSlice = 1;
  std::vector<int> sourceSlice;     // K index in the stack
  std::vector<float> target;        // [slice][ny][stride], normalised intensity
  std::vector<std::uint8_t> weight; // the same shape; 0 = not fitted
  std::int64_t samples = 0;         // with weight > 0
  int subset = 0;                   // of the data, see IterationOptions

  std::size_t sliceSize() const { return grid.planeSize(); }
  /// The grid's planes through one of the points; rendered one after the other, they fill bufferSize().
  SampleGrid gridOf(std::size_t point) const;
  std::size_t bufferSize() const { return grid.bufferSize() * points.size(); }
};

/// Quadrature of a slice profile: offsets along the normal (mm) and weights. `resolution`: the finest
/// relevant spacing (mm).
struct ProfileQuadrature {
  std::vector<double> offset, weight;
};
ProfileQuadrature profileQuadrature(SliceProfile profile, double thickness, double resolution);
/// Gauss's two-point rule for the profile: exact for cubic polynomials along the normal.
ProfileQuadrature twoPointQuadrature(SliceProfile profile, double thickness);

/// The same along the edges of pixels of a stack with this profile that average over `width` mm, for a volume
/// with this finest spacing (mm).
ProfileQuadrature pixelQuadrature(SliceProfile profile, double width, double resolution);

/// The points that this gives for a pixel.
struct PixelPoint {
  std::array<double, 2> offset; // from the pixel's centre: pixels along I and J
  double weight;                // sums to 1
};
std::vector<PixelPoint> pixelPoints(const ProfileQuadrature& edge, const Vec3& spacing);

/// The stack's thickness or, if that is 0, its slice spacing (mm).
double effectiveThickness(const Stack& stack);

/// Observations of a stack in the model frame: one for a regular stack, one per slice if slices have poses.
/// Leaves out slices without any finite observed voxel. closedForm: additive fields with a Gaussian profile
/// use the exact covariance instead of sub-planes. smoothAlongNormal: the field cannot vary much within the
/// slice thickness, so two-point quadrature suffices. resolution: the finest spacing of the field's data
/// (mm), for pixels that average.
std::vector<Observation> observe(const Stack& stack, const Affine3& modelToWorld, const IntensityMap& map,
                                 bool closedForm, bool smoothAlongNormal = false, double resolution = 0);

/// The observation at half the in-plane resolution, by averaging observed voxels, for coarse-to-fine fitting;
/// also half as many slices if they are as close as pixels; of a single slice, half as many sub-planes.
Observation coarsened(const Observation& fine);

} // namespace innergs
