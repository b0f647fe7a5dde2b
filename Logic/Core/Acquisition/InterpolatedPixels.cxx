#include "Core/Acquisition/InterpolatedPixels.h"

#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/Otsu.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr int kLobes = 6;
constexpr double kFactors[] = {1.25, 4.0 / 3, 1.5, 1.6, 1.75, 2, 2.5, 3, 4};
constexpr std::int64_t kFewestPixels = 32, kTriedSlices = 8;
// Chosen by measurement (Docs/method.md). What the first factor misses of pixels that were interpolated, and
// what any factor may miss, both medians, beside the detail that the larger pixels show; and the root mean
// square that a factor may miss, beside the noise.
constexpr double kInterpolated = 0.1, kMissed = 0.2, kMissedOfNoise = 0.2;
constexpr double kOwnDetail = 0.8; // least share of a slice's detail that its neighbours do not show

double lanczos(double x) {
  const double y = std::numbers::pi * x;
  if (std::abs(x) >= kLobes) return 0;
  return y == 0 ? 1 : std::sin(y) / y * std::sin(y / kLobes) / (y / kLobes);
}

/// Interpolates lines of n values at m places, `factor` times as far apart (below 1: nearer).
class Resampling {
public:
  Resampling(std::int64_t n, std::int64_t m, double factor) {
    for (std::int64_t i = 0; i < m; ++i) {
      const double at = (static_cast<double>(i) + 0.5) * factor - 0.5;
      Taps& taps = taps_.emplace_back();
      taps.first = std::max<std::int64_t>(0, static_cast<std::int64_t>(std::ceil(at - kLobes)));
      const std::int64_t last = std::min(n - 1, static_cast<std::int64_t>(std::floor(at + kLobes)));
      double sum = 0;
      for (std::int64_t x = taps.first; x <= last; ++x)
        sum += taps.weights.emplace_back(lanczos(static_cast<double>(x) - at));
      for (double& w : taps.weights)
        w /= sum;
    }
  }
  std::int64_t size() const { return static_cast<std::int64_t>(taps_.size()); }

  void line(const float* from, std::int64_t fromStep, float* to, std::int64_t toStep) const {
    for (const Taps& taps : taps_) {
      double sum = 0;
      const float* x = from + taps.first * fromStep;
      for (std::size_t t = 0; t < taps.weights.size(); ++t)
        sum += taps.weights[t] * x[static_cast<std::int64_t>(t) * fromStep];
      *to = static_cast<float>(sum);
      to += toStep;
    }
  }

private:
  struct Taps {
    std::int64_t first = 0;
    std::vector<double> weights;
  };
  std::vector<Taps> taps_;
};

std::int64_t largerCount(std::int64_t pixels, double factor) {
  return static_cast<std::int64_t>(static_cast<double>(pixels) / factor + 1e-6);
}

/// Median absolute value, as a standard deviation of normally distributed ones.
double deviationOf(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle / 0.6745;
}

/// What larger pixels miss in the foreground of some slices.
struct Missed {
  double share; // median, beside the detail that they show
  double rms;   // root mean square, the image's units
};

Missed missedBy(const Stack& stack, int axis, double factor, double threshold, ThreadPool& pool) {
  const auto& n = stack.image.geometry.size;
  const std::int64_t length = n[axis], lines = n[1 - axis], larger = largerCount(length, factor);
  const std::int64_t along = axis == 0 ? 1 : n[0], across = axis == 0 ? n[0] : 1;
  const Resampling down(length, larger, factor), up(larger, length, 1 / factor);
  const std::int64_t slices = std::min(n[2], kTriedSlices);
  std::vector<std::vector<float>> missed(static_cast<std::size_t>(slices)), shown = missed;
  pool.run(slices, [&](std::int64_t s) {
    const float* slice = stack.image.voxels.data() + (2 * s + 1) * n[2] / (2 * slices) * n[0] * n[1];
    std::vector<float> coarse(static_cast<std::size_t>(larger)), back(static_cast<std::size_t>(length));
    for (std::int64_t l = 0; l < lines; ++l) {
      const float* line = slice + l * across;
      down.line(line, along, coarse.data(), 1);
      up.line(coarse.data(), 1, back.data(), 1);
      for (std::int64_t i = kLobes; i < length - kLobes; ++i)
        if (line[i * along] > threshold) missed[s].push_back(std::abs(back[i] - line[i * along]));
      for (std::int64_t c = 1; c + 1 < larger; ++c)
        if (std::min({coarse[c - 1], coarse[c], coarse[c + 1]}) > threshold)
          shown[s].push_back(std::abs(coarse[c - 1] - 2 * coarse[c] + coarse[c + 1]));
    }
  });
  std::vector<float> allMissed, allShown;
  double squares = 0;
  for (std::int64_t s = 0; s < slices; ++s) {
    allMissed.insert(allMissed.end(), missed[s].begin(), missed[s].end());
    allShown.insert(allShown.end(), shown[s].begin(), shown[s].end());
    for (const float x : missed[s])
      squares += static_cast<double>(x) * x;
  }
  if (allMissed.empty() || allShown.empty()) return {1, 0};
  const double rms = std::sqrt(squares / static_cast<double>(allMissed.size()));
  const double detail = deviationOf(allShown) / std::sqrt(6.0); // of [1 −2 1]: √6 σ of white noise
  return {detail > 0 ? deviationOf(allMissed) / detail : 1, rms};
}

} // namespace

std::array<double, 2> interpolationFactors(const Stack& stack, ThreadPool& pool) {
  std::array<double, 2> found{1, 1};
  const auto& n = stack.image.geometry.size;
  const std::vector<float>& voxels = stack.image.voxels;
  if (n[2] < 1 || std::min(n[0], n[1]) < kFewestPixels ||
      !std::all_of(voxels.begin(), voxels.end(), [](float v) { return std::isfinite(v); }))
    return found;
  const double threshold = foregroundThreshold(voxels);
  std::array<std::vector<double>, 2> missed; // root mean square, by factors that may be
  for (int axis = 0; axis < 2; ++axis)
    for (const double factor : kFactors) {
      if (largerCount(n[axis], factor) < kFewestPixels / 2) break;
      const auto [share, rms] = missedBy(stack, axis, factor, threshold, pool);
      if (share > (missed[axis].empty() ? kInterpolated : kMissed)) break;
      missed[axis].push_back(rms);
      found[axis] = factor;
    }
  if (missed[0].empty() && missed[1].empty()) return found;
  // The noise of pixels that were interpolated is only seen without them: their neighbours share it. In
  // pixels that are too large, structure looks like noise, but slices share it.
  for (;;) {
    const Volume larger = withLargerPixels(stack, found, pool).image;
    if (ownShareOfDetail(larger) < kOwnDetail) return {1, 1};
    const double noise = estimateNoise(larger);
    std::array<double, 2> fitting{1, 1};
    for (int axis = 0; axis < 2; ++axis)
      for (std::size_t f = 0; f < missed[axis].size(); ++f)
        if (kFactors[f] <= found[axis] && missed[axis][f] <= kMissedOfNoise * noise)
          fitting[axis] = kFactors[f];
    if (fitting == found || fitting == std::array<double, 2>{1, 1}) return fitting;
    found = fitting;
  }
}

Stack withLargerPixels(const Stack& stack, const std::array<double, 2>& factors, ThreadPool& pool) {
  Stack result = stack;
  GridGeometry& g = result.image.geometry;
  for (int axis = 0; axis < 2; ++axis) {
    const double factor = factors[axis];
    if (factor == 1) continue;
    const auto n = g.size;
    const std::int64_t larger = largerCount(n[axis], factor);
    Vec3 first{};
    first[axis] = 0.5 * (factor - 1);
    g.origin = g.indexToWorld()(first);
    g.spacing[axis] *= factor;
    g.size[axis] = larger;
    const Resampling down(n[axis], larger, factor);
    const std::int64_t along = axis == 0 ? 1 : n[0], across = axis == 0 ? n[0] : 1;
    const std::int64_t newAcross = axis == 0 ? larger : 1, newAlong = axis == 0 ? 1 : n[0];
    const std::vector<float> from = std::move(result.image.voxels);
    result.image.voxels.assign(static_cast<std::size_t>(g.voxelCount()), 0.f);
    const std::vector<std::uint8_t> seen = std::move(result.observed);
    result.observed.assign(seen.empty() ? 0 : result.image.voxels.size(), 1);
    pool.run(n[2], [&](std::int64_t k) {
      const std::int64_t oldSlice = k * n[0] * n[1], newSlice = k * g.size[0] * g.size[1];
      for (std::int64_t l = 0; l < n[1 - axis]; ++l) {
        const std::int64_t oldLine = oldSlice + l * across, newLine = newSlice + l * newAcross;
        down.line(from.data() + oldLine, along, result.image.voxels.data() + newLine, newAlong);
        for (std::int64_t c = 0; !seen.empty() && c < larger; ++c) {
          const auto begin = static_cast<std::int64_t>(static_cast<double>(c) * factor + 1e-6);
          const auto end = std::min(
              n[axis], static_cast<std::int64_t>(std::ceil(static_cast<double>(c + 1) * factor - 1e-6)));
          for (std::int64_t i = begin; i < end; ++i)
            if (!seen[oldLine + i * along]) result.observed[newLine + c * newAlong] = 0;
        }
      }
    });
  }
  return result;
}

} // namespace innergs
