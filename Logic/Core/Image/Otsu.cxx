#include "Core/Image/Otsu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <vector>

namespace innergs {
namespace {

constexpr double kLeastForeground = 0.01; // of the finite values

} // namespace

double otsuThreshold(std::span<const float> values) {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  for (const float v : values) { // NaN compares false
    low = v < low && v >= std::numeric_limits<float>::lowest() ? v : low;
    high = v > high && v <= std::numeric_limits<float>::max() ? v : high;
  }
  if (!(low < high)) return low;
  constexpr int bins = 256;
  std::array<std::array<std::int64_t, bins>, 4>
      counts{}; // neighbours are often alike: not one after the other
  const double width = (double(high) - low) / bins;
  for (std::size_t n = 0; n < values.size(); ++n)
    if (std::isfinite(values[n]))
      ++counts[n % 4][std::min(bins - 1, static_cast<int>((double(values[n]) - low) / width))];
  std::array<double, bins> histogram{};
  for (int b = 0; b < bins; ++b)
    for (const auto& part : counts)
      histogram[b] += static_cast<double>(part[b]);

  double total = 0, moment = 0;
  for (int b = 0; b < bins; ++b) {
    total += histogram[b];
    moment += b * histogram[b];
  }
  double below = 0, momentBelow = 0, best = -1;
  int first = 0, last = 0; // a gap between the classes gives a plateau: takes its middle
  for (int b = 0; b + 1 < bins; ++b) {
    below += histogram[b];
    momentBelow += b * histogram[b];
    const double above = total - below;
    if (below == 0 || above == 0) continue;
    const double difference = momentBelow / below - (moment - momentBelow) / above;
    const double variance = below * above * difference * difference;
    if (variance > best * (1 + 1e-12)) {
      best = variance;
      first = last = b;
    } else if (variance >= best * (1 - 1e-12)) {
      last = b;
    }
  }
  return low + width * (0.5 * (first + last) + 1);
}

double foregroundThreshold(std::span<const float> values) {
  double threshold = otsuThreshold(values);
  const auto finite = std::count_if(values.begin(), values.end(), [](float v) { return std::isfinite(v); });
  std::vector<float> below;
  while (true) {
    const std::span<const float> all = below.empty() ? values : std::span<const float>(below);
    const auto isLeft = [threshold](float v) { return v <= threshold; };
    const auto left = std::count_if(all.begin(), all.end(), isLeft);
    if (left == 0 || static_cast<double>(finite - left) >= kLeastForeground * static_cast<double>(finite))
      return threshold;
    std::vector<float> rest;
    rest.reserve(static_cast<std::size_t>(left));
    std::copy_if(all.begin(), all.end(), std::back_inserter(rest), isLeft);
    const double next = otsuThreshold(rest);
    if (!(next < *std::max_element(rest.begin(), rest.end()))) return threshold; // what is left is constant
    threshold = next;
    below.swap(rest);
  }
}

} // namespace innergs
