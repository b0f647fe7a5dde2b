#include "Core/Prediction/SliceLines.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kSlices = 12;               // at most, in which lines run
constexpr std::int64_t kLineSamples = 200'000;     // along one axis, about
constexpr std::int64_t kAcrossSamples = 2'000'000; // through the slices, at most
constexpr double kDetail = 0.25;                   // reach of second differences, in slice distances

/// Filters row n of values [length][width].
void filterRow(const float* values, std::int64_t length, std::int64_t width, std::span<const double> kernel,
               std::int64_t n, float* to) {
  const auto reach = static_cast<std::int64_t>(kernel.size() / 2);
  std::fill_n(to, width, 0.f);
  for (std::int64_t t = -reach; t <= reach; ++t) {
    const float* from = values + std::clamp<std::int64_t>(n + t, 0, length - 1) * width;
    const auto w = static_cast<float>(kernel[t + reach]);
    for (std::int64_t i = 0; i < width; ++i)
      to[i] += w * from[i];
  }
}

SliceLines emptyLines(std::size_t samples, std::int64_t length) {
  SliceLines lines;
  lines.length = length;
  lines.width = static_cast<std::int64_t>(samples) / std::max<std::int64_t>(1, length);
  lines.value.reserve(samples);
  lines.inside.reserve(samples);
  return lines;
}

} // namespace

std::vector<std::int64_t> voxelsAcross(const GridGeometry& stack) {
  const auto& size = stack.size;
  const std::int64_t plane = size[0] * size[1],
                     step = std::max<std::int64_t>(1, plane * size[2] / kAcrossSamples);
  std::vector<std::int64_t> voxels;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t p = 0; p < plane; p += step)
      voxels.push_back(k * plane + p);
  return voxels;
}

std::vector<std::int64_t> voxelsWithin(const GridGeometry& stack, int axis) {
  const auto& size = stack.size;
  const std::int64_t slices = std::min(kSlices, size[2]), other = size[1 - axis];
  const std::int64_t step = std::max<std::int64_t>(1, slices * other * size[axis] / kLineSamples);
  std::vector<std::int64_t> starts, voxels;
  for (std::int64_t s = 0; s < slices; ++s) {
    const std::int64_t k = (2 * s + 1) * size[2] / (2 * slices);
    for (std::int64_t q = s % step; q < other; q += step)
      starts.push_back(k * size[0] * size[1] + q * (axis == 0 ? size[0] : 1));
  }
  for (std::int64_t n = 0; n < size[axis]; ++n)
    for (const std::int64_t start : starts)
      voxels.push_back(start + n * (axis == 0 ? 1 : size[0]));
  return voxels;
}

SliceLines linesAt(std::span<const std::int64_t> voxels, std::int64_t length, std::span<const float> image,
                   std::span<const std::uint8_t> inside) {
  SliceLines lines = emptyLines(voxels.size(), length);
  for (const std::int64_t v : voxels) {
    lines.value.push_back(image[v]);
    lines.inside.push_back(inside[v]);
  }
  return lines;
}

SliceLines detailAt(std::span<const std::int64_t> voxels, std::int64_t length, const GridGeometry& stack,
                    std::span<const float> image, std::span<const std::uint8_t> inside, int axis) {
  SliceLines lines = emptyLines(voxels.size(), length);
  const std::int64_t reach = std::max<std::int64_t>(
                         1, std::llround(kDetail * stack.spacing[2] / stack.spacing[axis])),
                     stride = axis == 0 ? 1 : stack.size[0];
  for (const std::int64_t v : voxels) {
    const std::int64_t at = v / stride % stack.size[axis], below = v - reach * stride,
                       above = v + reach * stride;
    const bool known =
        at >= reach && at + reach < stack.size[axis] && inside[v] && inside[below] && inside[above];
    lines.value.push_back(known ? image[below] - 2 * image[v] + image[above] : 0);
    lines.inside.push_back(known);
  }
  return lines;
}

SliceLines decimated(const SliceLines& in, std::int64_t factor, std::int64_t phase) {
  SliceLines out;
  out.length = in.length > phase ? (in.length - 1 - phase) / factor + 1 : 0;
  out.width = in.width;
  for (std::int64_t n = 0; n < out.length; ++n) {
    const std::int64_t at = (phase + n * factor) * in.width;
    out.value.insert(out.value.end(), in.value.begin() + at, in.value.begin() + at + in.width);
    out.inside.insert(out.inside.end(), in.inside.begin() + at, in.inside.begin() + at + in.width);
  }
  return out;
}

std::vector<float> sampledRows(const std::vector<float>& values, std::int64_t length, std::int64_t width,
                               std::span<const double> kernel, std::int64_t factor) {
  const std::int64_t rows = (length - 1) / factor + 1;
  std::vector<float> out(static_cast<std::size_t>(rows * width));
  for (std::int64_t n = 0; n < rows; ++n)
    filterRow(values.data(), length, width, kernel, n * factor, out.data() + n * width);
  return out;
}

double slopeShare(const SliceLines& slices) {
  std::vector<float> change;
  const auto visit = [&](auto&& see) {
    for (std::int64_t n = 1; n + 1 < slices.length; ++n)
      for (std::int64_t i = n * slices.width; i < (n + 1) * slices.width; ++i) {
        const std::int64_t below = i - slices.width, above = i + slices.width;
        if (slices.inside[below] && slices.inside[i] && slices.inside[above])
          see(slices.value[below], slices.value[i], slices.value[above]);
      }
  };
  visit([&](float a, float, float c) { change.push_back(std::abs(c - a)); });
  if (static_cast<std::int64_t>(change.size()) < kFewestSamples) return 0;
  const auto strong = change.begin() + static_cast<std::ptrdiff_t>(change.size() * 4 / 5);
  std::nth_element(change.begin(), strong, change.end());
  const float threshold = std::max(*strong, std::numeric_limits<float>::min());
  double sum = 0, count = 0;
  visit([&](float a, float b, float c) {
    if (std::abs(c - a) < threshold) return;
    const double p = std::clamp((static_cast<double>(b) - a) / (static_cast<double>(c) - a), 0.0, 1.0);
    sum += 4 * p * (1 - p);
    ++count;
  });
  return count > 0 ? sum / count : 0;
}

double changeShare(const SliceLines& slices) {
  double differences = 0, squares = 0;
  std::int64_t samples = 0;
  for (std::int64_t i = 0; i + slices.width < static_cast<std::int64_t>(slices.value.size()); ++i) {
    if (!slices.inside[i] || !slices.inside[i + slices.width]) continue;
    const double a = slices.value[i], b = slices.value[i + slices.width];
    differences += (a - b) * (a - b);
    squares += a * a + b * b;
    ++samples;
  }
  return samples >= kFewestSamples && squares > 0 ? differences / squares : 0;
}

} // namespace innergs
