#include "Core/Features/IntensityScale.h"

#include "Core/Image/Otsu.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {
constexpr std::size_t kKnots = 257;
constexpr float kBelow = -0.3f, kLowest = -0.7f;
} // namespace

float IntensityScale::operator()(float value) const {
  if (knots.size() < 2) return 0;
  if (!(value > low)) return kLowest; // for NaN too
  if (value < knots.front()) return kLowest + (kBelow - kLowest) * (value - low) / (knots.front() - low);
  const auto above = std::upper_bound(knots.begin(), knots.end(), value);
  if (above == knots.end()) return 1;
  const auto n = static_cast<float>(above - knots.begin() - 1);
  const float low = *(above - 1), high = *above;
  return (n + (value - low) / (high - low)) / static_cast<float>(knots.size() - 1);
}

IntensityScale intensityScaleOf(std::span<const float> voxels) {
  const double threshold = otsuThreshold(voxels);
  std::vector<float> above;
  IntensityScale scale;
  scale.low = std::numeric_limits<float>::max();
  for (const float value : voxels) {
    if (!std::isfinite(value)) continue;
    scale.low = std::min(scale.low, value);
    if (static_cast<double>(value) > threshold) above.push_back(value);
  }
  if (above.empty()) return {};
  std::sort(above.begin(), above.end());
  for (std::size_t n = 0; n < kKnots; ++n)
    scale.knots.push_back(above[n * (above.size() - 1) / (kKnots - 1)]);
  return scale;
}

} // namespace innergs
