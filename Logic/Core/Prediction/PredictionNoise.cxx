#include "Core/Prediction/PredictionNoise.h"

#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/WienerFilter.h"

#include <algorithm>
#include <span>
#include <vector>

namespace innergs {
namespace {

constexpr double kOwn = 0.75; // share of detail from which slices count as independent of each other

} // namespace

double unpredictedNoise(const Stack& scan, double noise) {
  if (!(noise > 0)) return noise;
  const double share = ownShareOfDetail(scan.image, scan.observed);
  return share < kOwn ? share * noise : noise;
}

void removePredictionNoise(Volume& missed, Stack& predicted, double scanNoise, ThreadPool& pool) {
  const auto& n = missed.geometry.size;
  const std::int64_t plane = n[0] * n[1];
  pool.run(n[2], [&](std::int64_t k) {
    const auto first = predicted.image.voxels.begin() + k * plane;
    Volume one{predicted.image.geometry, {first, first + plane}};
    one.geometry.size[2] = 1;
    std::span<const std::uint8_t> observed;
    if (!predicted.observed.empty()) observed = std::span(predicted.observed).subspan(k * plane, plane);
    const double noise = std::min(estimateNoise(one, observed), scanNoise);
    if (!(noise > 0)) return;
    const std::span<float> all = std::span(missed.voxels).subspan(k * plane, plane);
    const std::vector<float> before(all.begin(), all.end());
    wienerFilter(all, n[0], noise);
    for (std::int64_t p = 0; p < plane; ++p)
      predicted.image.voxels[k * plane + p] += all[p] - before[p];
  });
}

} // namespace innergs
