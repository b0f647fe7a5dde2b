#pragma once
#include <span>
#include <vector>

namespace innergs {

/// Maps intensities to ranks: 0 to 1 between the quantiles of the values above Otsu's threshold of an image,
/// and linearly from −0.7 to −0.3 below it. A difference then means the same in CT and MR, in bone and in
/// soft tissue.
struct IntensityScale {
  float low = 0;            // scanner value at −0.7
  std::vector<float> knots; // ascending scanner values at evenly spaced ranks from 0 to 1; empty: all is 0

  float operator()(float value) const;
};

/// The scale of an image's finite voxels.
IntensityScale intensityScaleOf(std::span<const float> voxels);

} // namespace innergs
