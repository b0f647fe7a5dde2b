#include "Core/Image/Otsu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

namespace innergs {
namespace {

constexpr double kLeastForeground = 0.01; // of the finite values

} // namespace

double otsuThreshold(std::span<const float> values) {
  float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
  for (float v : values)
    if (std::isfinite(v)) {
      low = std::min(low, v);
      high = std::max(high, v);
    }
  if (!(low < high)) return low;
  constexpr int bins = 256;
  std::array<double, bins> histogram{};
  const double width = (double(high) - low) / bins;
  for (float v : values)
    if (std::isfinite(v)) ++histogram[std::min(bins - 1, static_cast<int>((double(v) - low) / width))];

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
    std::vector<float> left;
    for (const float v : below.empty() ? values : std::span<const float>(below))
      if (v <= threshold) left.push_back(v);
    const auto above = finite - static_cast<std::int64_t>(left.size());
    if (left.empty() || static_cast<double>(above) >= kLeastForeground * static_cast<double>(finite))
      return threshold;
    const double next = otsuThreshold(left);
    if (!(next < *std::max_element(left.begin(), left.end()))) return threshold; // what is left is constant
    threshold = next;
    below.swap(left);
  }
}

} // namespace innergs
