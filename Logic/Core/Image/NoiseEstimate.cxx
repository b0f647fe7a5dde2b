#include "Core/Image/NoiseEstimate.h"
#include "Core/Image/Otsu.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

struct Sample {
  float near, far; // |response of [1 −2 1]⊗[1 −2 1]| to neighbours and to pixels two apart: 6σ of white noise
  float own; // the part of `near` that the slices on either side do not show; NaN: unknown or not asked for
  float gradient; // squared; antisymmetric filters, so independent of the noise in these
};

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();
constexpr double kTexture = 4; // variance of natural images at pixels two apart, over that of neighbours

// Median of values that may be quantised: ties are spread evenly over their quantisation step.
double interpolatedMedian(std::vector<float>& values) {
  const std::size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half), values.end());
  const float median = values[half];
  double below = 0, equal = 0;
  float previous = -1, next = -1; // neighbouring distinct values
  for (float v : values) {
    if (v < median) {
      ++below;
      previous = std::max(previous, v);
    } else if (v == median) {
      ++equal;
    } else if (next < 0 || v < next) {
      next = v;
    }
  }
  const double low = previous < 0 ? 0 : 0.5 * (double(previous) + median);
  const double high = next < 0 ? median : 0.5 * (double(next) + median);
  return low + (high - low) * (0.5 * double(values.size()) - below) / equal;
}

// Mean of the eight voxels two steps away in-plane. They share no noise with the second difference of
// neighbours, so selecting voxels by this mean does not select by noise.
double ringMean(const Volume& volume, std::int64_t i, std::int64_t j, std::int64_t k) {
  const auto& n = volume.geometry.size;
  const std::int64_t x[3] = {std::max<std::int64_t>(i - 2, 0), i, std::min(i + 2, n[0] - 1)};
  const std::int64_t y[3] = {std::max<std::int64_t>(j - 2, 0), j, std::min(j + 2, n[1] - 1)};
  double sum = 0;
  for (int b = 0; b < 3; ++b)
    for (int a = 0; a < 3; ++a)
      if (a != 1 || b != 1) sum += volume.voxels[x[a] + n[0] * (y[b] + n[1] * k)];
  return sum / 8;
}

struct Samples {
  std::vector<Sample> usable;
  std::size_t constant = 0; // neighbourhoods with a single value
};

constexpr std::size_t kFewest = 200;
constexpr std::int64_t kEnough = 1'000'000; // voxels: some rows and slices are left out of more
constexpr std::int64_t kFewestSlices = 16;  // of which all rows are looked at first

bool allInside(std::span<const std::uint8_t> mask, std::int64_t centre, std::int64_t width,
               std::int64_t step) {
  for (std::int64_t row = centre - step * width; row <= centre + step * width; row += step * width)
    if (!mask[row - step] || !mask[row] || !mask[row + step]) return false;
  return true;
}

/// The response of [1 −2 1]⊗[1 −2 1] at pixels `step` apart; w: from row to row.
double secondDifference(const float* p, std::int64_t w, std::int64_t step) {
  const std::int64_t r = step * w;
  const double c = p[0];
  return 4 * c - 2 * (double(p[-step]) + p[step] + p[-r] + p[r]) + p[-r - step] + p[-r + step] + p[r - step] +
         p[r + step];
}

/// Sample::own; NaN where one of the slices on either side is not known.
float ownDifference(const Volume& volume, std::span<const std::uint8_t> mask, std::int64_t centre,
                    std::int64_t k) {
  const auto& n = volume.geometry.size;
  const std::int64_t w = n[0], plane = n[0] * n[1];
  constexpr double kWhite = 1.2247448713915890; // √(1 + 2/4): of white noise
  if (k < 1 || k + 1 >= n[2]) return kUnknown;
  if (!mask.empty() && !(allInside(mask, centre - plane, w, 1) && allInside(mask, centre + plane, w, 1)))
    return kUnknown;
  const float* p = volume.voxels.data() + centre;
  return static_cast<float>(std::abs(secondDifference(p, w, 1) - 0.5 * (secondDifference(p - plane, w, 1) +
                                                                        secondDifference(p + plane, w, 1))) /
                            kWhite);
}

Samples collect(const Volume& volume, std::span<const std::uint8_t> mask, double threshold, bool withOwn) {
  const auto& n = volume.geometry.size;
  const std::int64_t step = std::max<std::int64_t>(1, volume.geometry.voxelCount() / kEnough),
                     sliceStep = std::min(step, std::max<std::int64_t>(1, n[2] / kFewestSlices)),
                     rowStep = std::max<std::int64_t>(1, step / sliceStep);
  Samples samples;
  for (std::int64_t k = 0; k < n[2]; k += sliceStep)
    for (std::int64_t j = 2; j + 2 < n[1]; j += rowStep)
      for (std::int64_t i = 2; i + 2 < n[0]; ++i) {
        const std::int64_t centre = i + n[0] * (j + n[1] * k), w = n[0];
        if (!mask.empty() && !(allInside(mask, centre, w, 1) && allInside(mask, centre, w, 2))) continue;
        if (!(ringMean(volume, i, j, k) > threshold)) continue;
        const float* p = volume.voxels.data() + centre;
        const double near = secondDifference(p, w, 1), far = secondDifference(p, w, 2);
        if (!std::isfinite(near + far)) continue;
        const auto [low, high] =
            std::minmax({p[-w - 1], p[-w], p[-w + 1], p[-1], p[0], p[1], p[w - 1], p[w], p[w + 1]});
        if (low == high) { // saturation or a label
          ++samples.constant;
          continue;
        }
        const double gx = double(p[1]) - p[-1] + 0.5 * (double(p[1 - w]) - p[-1 - w] + p[1 + w] - p[-1 + w]);
        const double gy = double(p[w]) - p[-w] + 0.5 * (double(p[w - 1]) - p[-w - 1] + p[w + 1] - p[-w + 1]);
        samples.usable.push_back({static_cast<float>(std::abs(near)), static_cast<float>(std::abs(far)),
                                  withOwn ? ownDifference(volume, mask, centre, k) : kUnknown,
                                  static_cast<float>(gx * gx + gy * gy)});
      }
  return samples;
}

bool hasThreeValues(std::span<const float> values) {
  std::vector<float> found;
  for (const float v : values) {
    if (!std::isfinite(v) || std::find(found.begin(), found.end(), v) != found.end()) continue;
    found.push_back(v);
    if (found.size() == 3) return true;
  }
  return false;
}

double thresholdInside(const std::vector<float>& voxels, std::span<const std::uint8_t> mask) {
  if (mask.empty()) return foregroundThreshold(voxels);
  std::vector<float> inside;
  for (std::size_t v = 0; v < voxels.size(); ++v)
    if (mask[v]) inside.push_back(voxels[v]);
  return foregroundThreshold(inside);
}

/// Median absolute second differences where the image is flattest; 0 for labelmaps.
struct SecondDifferences {
  double near = 0, far = 0; // of neighbours and of pixels two apart, as deviations of white noise
  double ownShare = 1;      // of `near`: what the slices on either side do not show; 1: unknown
};

SecondDifferences secondDifferences(const Volume& volume, std::span<const std::uint8_t> mask,
                                    bool withOwnShare = false) {
  const auto& n = volume.geometry.size;
  if (n[0] < 5 || n[1] < 5 || !hasThreeValues(volume.voxels)) return {};
  // Above Otsu's threshold: the noise in air is Rician, with a different deviation.
  auto [samples, constant] = collect(volume, mask, thresholdInside(volume.voxels, mask), withOwnShare);
  if (constant > samples.size()) return {};
  if (!mask.empty() && samples.size() < kFewest)
    return secondDifferences(volume, {}, withOwnShare); // too few: uses the whole scan
  if (samples.empty()) return {};
  // Edges would pass for noise, so only the flattest third counts.
  const auto keep = std::max<std::size_t>(std::min(samples.size(), kFewest), samples.size() / 3);
  std::nth_element(samples.begin(), samples.begin() + static_cast<std::ptrdiff_t>(keep - 1), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.gradient < b.gradient; });
  std::vector<float> near(keep), far(keep), own, between;
  for (std::size_t s = 0; s < keep; ++s) {
    near[s] = samples[s].near;
    far[s] = samples[s].far;
    if (!std::isfinite(samples[s].own)) continue;
    own.push_back(samples[s].own);
    between.push_back(samples[s].near);
  }
  constexpr double toDeviation = 1 / (0.6745 * 6);
  SecondDifferences found{toDeviation * interpolatedMedian(near), toDeviation * interpolatedMedian(far)};
  if (own.size() >= kFewest)
    if (const double all = interpolatedMedian(between); all > 0)
      found.ownShare = std::min(1.0, interpolatedMedian(own) / all);
  return found;
}

} // namespace

double estimateNoise(const Volume& volume, std::span<const std::uint8_t> mask) {
  const auto [near, far, ownShare] = secondDifferences(volume, mask);
  // White noise is as strong at both distances, texture is not.
  return std::min(near, std::sqrt(std::max(0.0, kTexture * near * near - far * far) / (kTexture - 1)));
}

double estimateFineDetail(const Volume& volume, std::span<const std::uint8_t> mask) {
  return secondDifferences(volume, mask).near;
}

double ownShareOfDetail(const Volume& volume, std::span<const std::uint8_t> mask) {
  return secondDifferences(volume, mask, true).ownShare;
}

} // namespace innergs
