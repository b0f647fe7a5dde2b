#include "Core/Prediction/PredictionNoise.h"

#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/WienerFilter.h"

#include <algorithm>
#include <numeric>
#include <span>
#include <vector>

namespace innergs {
namespace {

constexpr double kNoticedNoise = 0.15; // of the variance missed

} // namespace

void removePredictionNoise(Volume& missed, Stack& predicted, double scanNoise, ThreadPool& pool) {
  const auto& n = missed.geometry.size;
  const std::int64_t plane = n[0] * n[1];
  std::vector<double> noise(static_cast<std::size_t>(n[2])), squares(noise), variances(noise);
  pool.run(n[2], [&](std::int64_t k) {
    const auto first = predicted.image.voxels.begin() + k * plane;
    Volume one{predicted.image.geometry, {first, first + plane}};
    one.geometry.size[2] = 1;
    std::span<const std::uint8_t> observed;
    if (!predicted.observed.empty()) observed = std::span(predicted.observed).subspan(k * plane, plane);
    noise[k] = std::min(estimateNoise(one, observed), scanNoise);
    for (std::int64_t p = 0; p < plane; ++p) {
      if (!observed.empty() && !observed[p]) continue;
      const double d = missed.voxels[k * plane + p];
      squares[k] += d * d;
      variances[k] += noise[k] * noise[k];
    }
  });
  const auto sum = [](const std::vector<double>& x) { return std::accumulate(x.begin(), x.end(), 0.0); };
  if (sum(variances) < kNoticedNoise * sum(squares)) return;
  pool.run(n[2], [&](std::int64_t k) {
    const std::span<float> all = std::span(missed.voxels).subspan(k * plane, plane);
    const std::vector<float> before(all.begin(), all.end());
    wienerFilter(all, n[0], noise[k]);
    for (std::int64_t p = 0; p < plane; ++p)
      predicted.image.voxels[k * plane + p] += all[p] - before[p];
  });
}

} // namespace innergs
