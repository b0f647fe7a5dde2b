#include "Core/Prediction/PatchFeatures.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

int reflected(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

/// The moments of a row of patches, by sums over their columns.
class RowMoments {
public:
  explicit RowMoments(std::size_t width) : sums_(width), squares_(width) {}

  /// rows[r]: columns 0 … width − 1 of a patch row. Sets those of the patches from `first` to last − 1.
  void set(const float* const* rows, int first, int last, float floor, float* mean, float* deviation) {
    const int end = last + PatchFeatures::width - 1;
    std::fill(sums_.begin() + first, sums_.begin() + end, 0.0);
    std::fill(squares_.begin() + first, squares_.begin() + end, 0.0);
    for (int r = 0; r < PatchFeatures::rows; ++r)
      for (int c = first; c < end; ++c) {
        const double value = rows[r][c];
        sums_[c] += value;
        squares_[c] += value * value;
      }
    for (int c = first; c < last; ++c) {
      double sum = 0, square = 0;
      for (int i = 0; i < PatchFeatures::width; ++i) {
        sum += sums_[c + i];
        square += squares_[c + i];
      }
      const double middle = sum / PatchFeatures::count;
      const double variance = std::max(0.0, square / PatchFeatures::count - middle * middle);
      mean[c] = static_cast<float>(middle);
      deviation[c] = floor > 0 ? static_cast<float>(std::sqrt(variance + double{floor} * floor)) : 1.f;
    }
  }

private:
  std::vector<double> sums_, squares_;
};

/// out = (the patch at column c − mean)·scale. Writes vectors of 8: the next row overwrites the last one, the
/// end of the stride takes that of the last row. Reads one column past the patch.
void normalisedPatch(const float* const* rows, int c, float mean, float scale, float* out) {
  static_assert(PatchFeatures::stride == PatchFeatures::count + 1);
  for (int r = 0; r < PatchFeatures::rows; ++r)
    for (int i = 0; i < PatchFeatures::width + 1; ++i)
      out[r * PatchFeatures::width + i] = (rows[r][c + i] - mean) * scale;
  out[PatchFeatures::count] = 0;
}

} // namespace

void makeFeatures(const float* low, int stack, int columns, float floor, PatchFeatures& features, int before,
                  int after, std::span<const ColumnSpan> spans) {
  constexpr int halfRows = PatchFeatures::rows / 2, halfWidth = PatchFeatures::width / 2;
  const int slices = stack + before + after;
  features.slices = slices;
  features.before = before;
  features.after = after;
  features.columns = columns;
  features.spans.assign(spans.begin(), spans.end());
  features.values.resize(static_cast<std::size_t>(features.samples()) * PatchFeatures::stride);
  features.mean.assign(static_cast<std::size_t>(features.samples()), 0.f);
  features.deviation.assign(static_cast<std::size_t>(features.samples()), 0.f);
  const int paddedWidth = columns + 2 * halfWidth;
  std::vector<float> padded(static_cast<std::size_t>(stack) * paddedWidth + 1); // for normalisedPatch()
  RowMoments moments(static_cast<std::size_t>(paddedWidth));
  for (int s = 0; s < stack; ++s) {
    const float* in = low + static_cast<std::size_t>(s) * columns;
    float* out = padded.data() + static_cast<std::size_t>(s) * paddedWidth;
    std::copy_n(in, columns, out + halfWidth);
    for (int c = 0; c < halfWidth; ++c) {
      out[halfWidth - 1 - c] = in[reflected(-1 - c, columns)];
      out[halfWidth + columns + c] = in[reflected(columns + c, columns)];
    }
  }
  for (int s = 0; s < slices; ++s) {
    std::fill_n(features.values.data() + features.at(s, -1) * PatchFeatures::stride, PatchFeatures::stride,
                0.f);
    std::fill(features.values.data() + features.at(s, columns) * PatchFeatures::stride,
              features.values.data() + features.at(s + 1, -1) * PatchFeatures::stride, 0.f);
    const float* rows[PatchFeatures::rows];
    for (int r = 0; r < PatchFeatures::rows; ++r)
      rows[r] =
          padded.data() + static_cast<std::size_t>(reflected(s - before + r - halfRows, stack)) * paddedWidth;
    const ColumnSpan span = spans.empty() ? ColumnSpan{0, columns} : spans[s];
    if (span.first >= span.last) continue;
    float* mean = features.mean.data() + features.at(s, 0);
    float* deviation = features.deviation.data() + features.at(s, 0);
    moments.set(rows, span.first, span.last, floor, mean, deviation);
    for (int c = span.first; c < span.last; ++c)
      normalisedPatch(rows, c, mean[c], 1 / deviation[c],
                      features.values.data() + features.at(s, c) * PatchFeatures::stride);
  }
}

} // namespace innergs
