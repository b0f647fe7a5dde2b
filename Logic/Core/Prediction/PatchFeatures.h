#pragma once
#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/SliceSampling.h"

#include <span>

namespace innergs {

/// Columns first … last − 1 of a row of samples.
struct ColumnSpan {
  int first = 0, last = 0;
};

/// Columns in whole tiles, with one more at each end.
constexpr std::int64_t paddedColumnsOf(std::int64_t columns) {
  return (columns + ImageTiles::width - 1) / ImageTiles::width * ImageTiles::width + 2;
}

/// The inputs of a linear filter and a network for every sample of an image of slices [slice][column]: the
/// samples around it, minus their mean, divided by their deviation.
struct PatchFeatures {
  static constexpr int rows = 9, width = 7, count = rows * width, stride = 64;

  int slices = 0, columns = 0;
  int before = 0, after = 0; // how many of the slices lie beyond each end of the stack
  std::vector<float> values; // [slice][paddedColumns()][stride]
  // Of the patch, image units; [slice][paddedColumns()].
  std::vector<float> mean, deviation;
  std::vector<ColumnSpan> spans; // of each slice, the only samples that are computed; empty: all

  std::int64_t paddedColumns() const { return paddedColumnsOf(columns); }
  std::int64_t samples() const { return slices * paddedColumns(); }
  std::int64_t at(int slice, int column) const { return slice * paddedColumns() + column + 1; }
  /// Calls run(first sample, count) for the samples that are computed.
  template <typename Run>
  void forComputed(Run&& run) const {
    if (spans.empty()) return run(0, samples());
    for (int s = 0; s < slices; ++s)
      if (spans[s].first < spans[s].last) run(at(s, spans[s].first), spans[s].last - spans[s].first);
  }
};

/// low: [slice][column] of a stack of `stack` slices, continued by reflection, also for the `before` and
/// `after` slices beyond its ends. `floor`: minimum of the deviation, image units; 0: values are not divided,
/// and the deviation is 1. spans: one per slice, those beyond the ends included; empty: all samples.
void makeFeatures(const float* low, int stack, int columns, float floor, PatchFeatures& features,
                  int before = 0, int after = 0, std::span<const ColumnSpan> spans = {});

/// Outputs per sample, one per phase, padded to the columns of a product.
inline int outputStride(int phases) {
  return (phases + 7) / 8 * 8;
}

} // namespace innergs
