#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Prediction/SliceSampling.h"

#include <array>

namespace innergs {

/// How fast an image changes: mean squared differences at a distance, between voxels that count, along an
/// in-plane axis and across the slices. Noise is taken off as white.
struct StructureFunctions {
  static constexpr int lags = 2; // one and two slice distances
  std::array<double, lags> along{}, across{};
  double samples = 0;    // the fewest differences in a mean
  double noiseShare = 0; // the largest share of a mean that was noise

  /// How much rougher the image is along than across, as the logarithm of the ratios' ratio: below 0, it is
  /// smoother.
  double roughness() const;
};

/// Lines of an image along one in-plane axis, enough of them for the means.
class StructureLines {
public:
  /// inside: 1 where the image may be looked at. The body's own outline is no structure of its inside and
  /// should lie without.
  StructureLines(const Volume& image, const std::vector<std::uint8_t>& inside, int axis, double noise);

  /// After `filter` was applied along the in-plane axis. Blurred so by the slice profile, an isotropic image
  /// changes as fast along the axis as across the slices.
  StructureFunctions after(const LineFilter& filter, ThreadPool& pool) const;

private:
  std::int64_t lines_ = 0, slices_ = 0, length_ = 0;
  double perSlice_ = 1; // samples along the axis per slice distance
  double noise_ = 0;
  std::vector<float> values_;         // [line][slice][sample]
  std::vector<std::uint16_t> margin_; // samples to the nearest outside, along the axis; 0: outside
};

} // namespace innergs
