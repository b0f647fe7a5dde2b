#pragma once
#include "Core/Prediction/SliceSampling.h"

namespace innergs {

/// What a linear filter and a network see of every sample of an image of slices [slice][column]: the samples
/// around it, less their mean, by their deviation.
struct PatchFeatures {
  static constexpr int rows = 7, width = 9, count = rows * width, stride = 64;

  int slices = 0, columns = 0;
  // Samples in memory order with a column more on either side, where everything is 0: neighbours along a row
  // are neighbours of the image or border.
  std::vector<float> values; // [slice][1 + columns + 1][stride]
  // Of the patch, image units; [slice][1 + columns + 1].
  std::vector<float> mean, deviation;

  int paddedColumns() const { return columns + 2; }
  std::int64_t samples() const { return static_cast<std::int64_t>(slices) * paddedColumns(); }
  std::int64_t at(int slice, int column) const {
    return static_cast<std::int64_t>(slice) * paddedColumns() + column + 1;
  }
};

/// The image continues by reflection. `floor`: image units; no deviation is taken for smaller. 0: values are
/// not divided at all, deviation is 1.
void makeFeatures(const float* low, int slices, int columns, float floor, PatchFeatures& features);

/// Of one sample: `values` holds its patch [rows][width], stride long; it becomes features.
void normalisePatch(float floor, float* values, float& mean, float& deviation);

/// Outputs per sample, one per phase: columns of every product.
inline int outputStride(int phases) {
  return (phases + 15) / 16 * 16;
}

} // namespace innergs
