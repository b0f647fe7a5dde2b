#include "Core/Image/Otsu.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace innergs {

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

} // namespace innergs
