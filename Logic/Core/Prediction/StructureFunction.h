#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Prediction/SliceSampling.h"

#include <array>

namespace innergs {

/// How fast an image changes: mean squared differences at a distance between counted voxels, along an
/// in-plane axis and across the slices. Noise is subtracted as white.
struct StructureFunctions {
  static constexpr int lags = 2; // one and two slice distances
  std::array<double, lags> along{}, across{};
  double samples = 0;    // the smallest number of differences in a mean
  double noiseShare = 0; // the largest share of noise in a mean

  /// How much rougher the image is along than across, as the logarithm of the ratio of ratios; negative:
  /// smoother.
  double roughness() const;
};

/// Lines of an image along one in-plane axis, enough for the means.
class StructureLines {
public:
  /// inside: 1 where the image may be used. Exclude the body's outline, which is no structure of its inside.
  StructureLines(const Volume& image, const std::vector<std::uint8_t>& inside, int axis, double noise);

  /// The structure functions after applying `filter` along the in-plane axis. Blurred by the slice profile,
  /// an isotropic image changes as fast along the axis as across the slices.
  StructureFunctions after(const LineFilter& filter, ThreadPool& pool) const;

private:
  std::int64_t lines_ = 0, slices_ = 0, length_ = 0;
  double perSlice_ = 1; // samples along the axis per slice distance
  double noise_ = 0;
  std::vector<float> values_;         // [line][slice][sample]
  std::vector<std::uint16_t> margin_; // samples to the nearest outside one along the axis; 0: outside
};

} // namespace innergs
