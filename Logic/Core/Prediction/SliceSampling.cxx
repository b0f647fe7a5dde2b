#include "Core/Prediction/SliceSampling.h"

#include "Core/Acquisition/Observation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr double kOnSample = 1e-4;

// Windowed sinc (radius 4) at fraction f in [0, 1) after the fourth of eight samples.
std::array<double, 8> sincWeights(double f) {
  std::array<double, 8> weights{};
  double sum = 0;
  for (int t = 0; t < 8; ++t) {
    const double x = std::numbers::pi * (f - (t - 3));
    weights[t] = std::abs(x) < 1e-9 ? 1 : 4 * std::sin(x) * std::sin(x / 4) / (x * x);
    sum += weights[t];
  }
  for (double& w : weights)
    w /= sum;
  return weights;
}

LineFilter trimmed(int first, std::vector<double> weights) {
  double sum = 0;
  for (double w : weights)
    sum += w;
  std::size_t begin = 0, end = weights.size();
  while (end - begin > 1 && std::abs(weights[begin]) < 1e-6 * sum)
    ++begin;
  while (end - begin > 1 && std::abs(weights[end - 1]) < 1e-6 * sum)
    --end;
  LineFilter filter{first + static_cast<int>(begin), {}};
  for (std::size_t i = begin; i < end; ++i)
    filter.weights.push_back(static_cast<float>(weights[i] / sum));
  return filter;
}

LineFilter sampleAt(double centre) {
  const double base = std::floor(centre + kOnSample), f = centre - base;
  if (std::abs(f) <= kOnSample) return {static_cast<int>(base), {1.f}};
  const auto w = sincWeights(f);
  return trimmed(static_cast<int>(base) - 3, {w.begin(), w.end()});
}

// Thin samples are averages over their own cell, so a box weighs each by the part of the cell it covers.
LineFilter box(double centre, double width) {
  const int first = static_cast<int>(std::floor(centre - width / 2 + 0.5 + kOnSample));
  const int last = static_cast<int>(std::ceil(centre + width / 2 - 0.5 - kOnSample));
  std::vector<double> weights;
  for (int i = first; i <= last; ++i)
    weights.push_back(
        std::max(0.0, std::min(i + 0.5, centre + width / 2) - std::max(i - 0.5, centre - width / 2)));
  return trimmed(first, weights);
}

LineFilter gaussianAt(double centre, double sigma) {
  const double reach = std::max(1.0, 3.2 * sigma);
  std::vector<double> weights;
  const int first = static_cast<int>(std::ceil(centre - reach));
  for (int i = first; i <= centre + reach; ++i)
    weights.push_back(std::exp(-0.5 * (i - centre) * (i - centre) / (sigma * sigma)));
  return trimmed(first, weights);
}

} // namespace

LineFilter gaussianFilter(double sigma) {
  if (sigma < 0.05) return {0, {1.f}};
  if (sigma >= 0.5) return gaussianAt(0, sigma);
  // A sampled Gaussian this narrow has too small a variance; uses three samples with the right one instead.
  const auto side = static_cast<float>(sigma * sigma / 2);
  return {-1, {side, 1 - 2 * side, side}};
}

LineFilter convolved(const LineFilter& a, const LineFilter& b) {
  LineFilter result{a.first + b.first, std::vector<float>(a.weights.size() + b.weights.size() - 1, 0.f)};
  for (std::size_t i = 0; i < a.weights.size(); ++i)
    for (std::size_t j = 0; j < b.weights.size(); ++j)
      result.weights[i + j] += a.weights[i] * b.weights[j];
  return result;
}

LineFilter profileFilter(SliceProfile profile, double width, double centre) {
  if (profile == SliceProfile::Point || width <= 1 + kOnSample) return sampleAt(centre);
  if (profile == SliceProfile::Box) return box(centre, width);
  return gaussianAt(centre, std::max(0.4, width / 2.355));
}

SliceSampling sliceSampling(const Stack& stack, const GridGeometry& thin, int phases) {
  const GridGeometry& g = stack.image.geometry;
  SliceSampling s;
  s.phases = phases;
  s.pitch = g.spacing[2] / phases;
  const double firstThin = dot(thin.origin - g.origin, column(g.direction, 2)) / g.spacing[2];
  s.centre = -firstThin * phases;
  s.firstPhase = static_cast<int>(std::floor(s.centre - 0.5 * (phases - 1) + 0.5 + kOnSample));
  const double width = effectiveThickness(stack) / s.pitch;
  s.slice = profileFilter(stack.profile, width, s.centre);
  return s;
}

std::vector<float> resampledAlong(const float* values, std::int64_t outer, std::int64_t n, std::int64_t inner,
                                  const LinePositions& positions, std::int64_t count, ThreadPool* pool) {
  struct Taps {
    std::int64_t first = 0;
    int count = 8;
    std::array<double, 8> weights{};
  };
  std::vector<Taps> taps(static_cast<std::size_t>(count));
  for (std::int64_t t = 0; t < count; ++t) {
    const double x = std::clamp(positions.first + positions.step * static_cast<double>(t), 0.0,
                                static_cast<double>(n - 1));
    const double nearest = std::round(x);
    if (std::abs(x - nearest) < kOnSample)
      taps[t] = {static_cast<std::int64_t>(nearest), 1, {1}};
    else
      taps[t] = {static_cast<std::int64_t>(std::floor(x)) - 3, 8, sincWeights(x - std::floor(x))};
  }
  std::vector<float> out(static_cast<std::size_t>(outer * count * inner), 0.f);
  const auto fill = [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t row = from; row < to; ++row) {
      const std::int64_t o = row / count, t = row % count;
      float* line = out.data() + row * inner;
      for (int w = 0; w < taps[t].count; ++w) {
        const std::int64_t at = std::clamp<std::int64_t>(taps[t].first + w, 0, n - 1);
        const float* in = values + (o * n + at) * inner;
        const auto weight = static_cast<float>(taps[t].weights[w]);
        for (std::int64_t i = 0; i < inner; ++i)
          line[i] += weight * in[i];
      }
    }
  };
  constexpr std::int64_t piece = 1 << 16; // samples
  if (pool)
    pool->blocks(outer * count, std::max<std::int64_t>(1, piece / inner), fill);
  else
    fill(0, outer * count);
  return out;
}

} // namespace innergs
