#pragma once
#include <span>
#include <vector>

namespace innergs {

/// Intensities by their rank: 0 to 1 between the quantiles of what lies above Otsu's threshold of an image;
/// below it they run straight from −0.7 to −0.3. So a difference means the same in CT and MR, in bone and in
/// soft tissue.
struct IntensityScale {
  float low = 0;            // scanner value at −0.7
  std::vector<float> knots; // ascending scanner values at evenly spaced ranks from 0 to 1; empty: all is 0

  float operator()(float value) const;
};

/// Of an image's voxels; those that are not finite do not count.
IntensityScale intensityScaleOf(std::span<const float> voxels);

} // namespace innergs
