#include "Core/Prediction/PatchFeatures.h"

#include <algorithm>

namespace innergs {
namespace {

int reflected(int i, int n) {
  if (n == 1) return 0;
  const int period = 2 * (n - 1);
  i = ((i % period) + period) % period;
  return i < n ? i : period - i;
}

} // namespace

void makeFeatures(const float* low, int stack, int columns, float floor, const MatrixKernels& kernels,
                  PatchFeatures& features, int before, int after, std::span<const ColumnSpan> spans) {
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
  std::vector<float> padded(static_cast<std::size_t>(stack) * paddedWidth);
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
    for (int c = span.first; c < span.last; ++c) {
      const std::int64_t at = features.at(s, c);
      float* out = features.values.data() + at * PatchFeatures::stride;
      for (int r = 0; r < PatchFeatures::rows; ++r)
        std::copy_n(rows[r] + c, PatchFeatures::width, out + r * PatchFeatures::width);
      kernels.normalise(PatchFeatures::count, floor, out, features.mean[at], features.deviation[at]);
    }
  }
}

} // namespace innergs
