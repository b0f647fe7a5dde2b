#include "Evaluation/IntervalScore.h"

#include "Core/Uncertainty/ErrorCurve.h"

#include <cmath>

namespace innergs {

IntervalScore intervalScore(const Volume& image, const Volume& truth, std::span<const std::uint8_t> mask,
                            const Uncertainty& uncertainty, const Volume& deviation, double truthNoise) {
  std::int64_t held = 0, count = 0;
  std::vector<float> widths;
  for (std::size_t v = 0; v < mask.size(); ++v) {
    if (!mask[v] || !std::isfinite(truth.voxels[v])) continue;
    const double width = std::hypot(deviation.voxels[v], truthNoise);
    held += std::abs(static_cast<double>(image.voxels[v]) - truth.voxels[v]) <= kNinety * width;
    widths.push_back(deviation.voxels[v]);
    ++count;
  }
  return {static_cast<double>(held) / static_cast<double>(std::max<std::int64_t>(1, count)),
          uncertainty.coverage, quantile(widths, 0.5)};
}

} // namespace innergs
