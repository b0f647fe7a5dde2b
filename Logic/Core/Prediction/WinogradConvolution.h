#pragma once
#include "Core/Prediction/NetworkKernels.h"
#include "Core/Prediction/PatchFeatures.h"

namespace innergs {

/// An image [row][column][channel] with a border of zeros: one row above and one below, one column before,
/// and after the columns as many as complete a tile, and one.
struct BorderedImage {
  std::int64_t rows = 0, columns = 0;
  int channels = 0;

  std::int64_t width() const { return paddedColumnsOf(columns); }
  std::size_t size() const { return static_cast<std::size_t>((rows + 2) * width() * channels); }
  /// Index of a row's border column; rows −1 … `rows`.
  std::int64_t row(std::int64_t row) const { return (row + 1) * width() * channels; }
  bool operator==(const BorderedImage&) const = default;
};

/// 3×3 convolutions with 4/9 of the products of the plain sum: along the columns, Winograd's F(6, 3) makes 6
/// outputs from 8 products (Lavin and Gray 2016). Holds memory that calls reuse.
class WinogradConvolution {
public:
  static constexpr double productShare = 4. / 9; // relative to the plain sum

  /// Weights [row tap][column tap][input][output] at the points of F(6, 3): [point][row tap][input][output].
  static std::vector<float> transformed(const float* weights, int inputs, int outputs);

  /// Writes the columns `spans` (one per row; empty: all) of the convolved image plus `biases`, multiplied by
  /// `leak` where below 0, and 0 to the other columns, including those of the border. out: of an image with
  /// `outputs` channels, from row 0's border column on.
  void convolve(const BorderedImage& in, const float* image, const std::vector<float>& transformedWeights,
                int outputs, std::span<const ColumnSpan> spans, const float* biases, float leak,
                const NetworkKernels& kernels, float* out);

  /// Adds the gradient of a loss by the weights, given its derivative by the convolved image, 0 at its
  /// border.
  void addWeightGradient(const BorderedImage& in, const float* image, int outputs, const float* outGradient,
                         const NetworkKernels& kernels, float* weightGradient);

private:
  std::vector<float> input_, output_, weights_; // at the points
};

/// Sets the columns of a row of an image to 0 that lie outside the span, including the border.
void clearOutside(const BorderedImage& image, ColumnSpan span, float* row);

} // namespace innergs
