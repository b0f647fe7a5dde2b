#include "Core/Prediction/StructureFunction.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr std::int64_t kMostSamples = 1'500'000;

struct Sum {
  double squares = 0, count = 0;
  void add(double difference) {
    squares += difference * difference;
    ++count;
  }
};

struct LineSums {
  std::array<std::array<Sum, 2>, StructureFunctions::lags> along; // at the samples just below and above a lag
  std::array<Sum, StructureFunctions::lags> across;
};

double autocorrelation(const std::vector<float>& weights, std::int64_t lag) {
  double sum = 0;
  for (std::size_t i = 0; i + static_cast<std::size_t>(lag) < weights.size(); ++i)
    sum += static_cast<double>(weights[i]) * weights[i + static_cast<std::size_t>(lag)];
  return sum;
}

} // namespace

double StructureFunctions::roughness() const {
  return std::log(along[0] / along[1]) - std::log(across[0] / across[1]);
}

StructureLines::StructureLines(const Volume& image, const std::vector<std::uint8_t>& inside, int axis,
                               double noise)
    : noise_(noise) {
  const auto& n = image.geometry.size;
  length_ = n[axis];
  slices_ = n[2];
  perSlice_ = image.geometry.spacing[2] / image.geometry.spacing[axis];
  const std::int64_t all = n[1 - axis];
  lines_ = std::clamp<std::int64_t>(kMostSamples / (length_ * slices_), 1, all);
  const std::int64_t step = axis == 0 ? 1 : n[0], lineStep = axis == 0 ? n[0] : 1;
  const auto total = static_cast<std::size_t>(lines_ * slices_ * length_);
  values_.resize(total);
  margin_.resize(total);
  for (std::int64_t l = 0; l < lines_; ++l)
    for (std::int64_t k = 0; k < slices_; ++k) {
      const std::int64_t line = (2 * l + 1) * all / (2 * lines_);
      const std::int64_t from = k * n[0] * n[1] + line * lineStep, to = (l * slices_ + k) * length_;
      std::int64_t margin = 0;
      for (std::int64_t t = 0; t < length_; ++t) {
        values_[to + t] = image.voxels[from + t * step];
        margin = inside[from + t * step] ? margin + 1 : 0;
        margin_[to + t] = static_cast<std::uint16_t>(std::min<std::int64_t>(margin, 65535));
      }
      margin = 0;
      for (std::int64_t t = length_ - 1; t >= 0; --t) {
        margin = margin_[to + t] == 0 ? 0 : margin + 1;
        margin_[to + t] =
            std::min(margin_[to + t], static_cast<std::uint16_t>(std::min<std::int64_t>(margin, 65535)));
      }
    }
}

StructureFunctions StructureLines::after(const LineFilter& filter, ThreadPool& pool) const {
  constexpr int lags = StructureFunctions::lags;
  const std::int64_t reach = std::max(-filter.first, filter.last());
  std::array<std::int64_t, lags> below;
  std::array<double, lags> fraction;
  for (int l = 0; l < lags; ++l) {
    const double lag = perSlice_ * (l + 1);
    below[l] = static_cast<std::int64_t>(std::floor(lag + 1e-6));
    fraction[l] = lag - static_cast<double>(below[l]);
    if (fraction[l] < 1e-3) fraction[l] = 0;
  }
  std::vector<LineSums> parts(static_cast<std::size_t>(lines_));
  pool.run(lines_, [&](std::int64_t line) {
    const std::int64_t start = line * slices_ * length_;
    std::vector<float> out(static_cast<std::size_t>(slices_ * length_), 0.f);
    std::vector<std::uint8_t> use(out.size());
    for (std::int64_t k = 0; k < slices_; ++k)
      for (std::int64_t t = 0; t < length_; ++t) {
        const std::int64_t v = k * length_ + t;
        use[v] = margin_[start + v] > reach;
        if (!use[v]) continue;
        float sum = 0;
        for (std::size_t i = 0; i < filter.weights.size(); ++i)
          sum += filter.weights[i] * values_[start + v + filter.first + static_cast<std::int64_t>(i)];
        out[v] = sum;
      }
    // Measures along and across from the same voxels, because the body differs from place to place.
    LineSums& sums = parts[line];
    const std::int64_t farthest = below[lags - 1] + (fraction[lags - 1] > 0);
    for (std::int64_t k = 0; k + lags < slices_; ++k)
      for (std::int64_t t = farthest; t + farthest < length_; ++t) {
        const std::int64_t v = k * length_ + t;
        bool all = use[v];
        for (int l = 0; l < lags && all; ++l) {
          all = use[v + (l + 1) * length_];
          for (int side = 0; side < (fraction[l] > 0 ? 2 : 1); ++side)
            all = all && use[v + below[l] + side] && use[v - below[l] - side];
        }
        if (!all) continue;
        const double here = out[v];
        for (int l = 0; l < lags; ++l) {
          for (int side = 0; side < (fraction[l] > 0 ? 2 : 1); ++side) {
            sums.along[l][side].add(here - out[v + below[l] + side]);
            sums.along[l][side].add(here - out[v - below[l] - side]);
          }
          sums.across[l].add(here - out[v + (l + 1) * length_]);
        }
      }
  });
  LineSums all;
  for (const LineSums& part : parts)
    for (int l = 0; l < lags; ++l) {
      for (int side = 0; side < 2; ++side) {
        all.along[l][side].squares += part.along[l][side].squares;
        all.along[l][side].count += part.along[l][side].count;
      }
      all.across[l].squares += part.across[l].squares;
      all.across[l].count += part.across[l].count;
    }
  StructureFunctions result;
  result.samples = std::numeric_limits<double>::max();
  const double variance = noise_ * noise_, kept = autocorrelation(filter.weights, 0);
  const auto mean = [&](const Sum& sum, double noise) {
    result.samples = std::min(result.samples, sum.count);
    const double raw = sum.squares / std::max(1.0, sum.count);
    result.noiseShare = std::max(result.noiseShare, raw > 0 ? noise / raw : 1);
    return std::max(raw - noise, 1e-9 * raw);
  };
  for (int l = 0; l < lags; ++l) {
    double along = 0;
    for (int side = 0; side < 2; ++side) {
      const double share = side ? fraction[l] : 1 - fraction[l];
      if (share < 1e-6) continue;
      along += share * mean(all.along[l][side],
                            2 * variance * (kept - autocorrelation(filter.weights, below[l] + side)));
    }
    result.along[l] = along;
    result.across[l] = mean(all.across[l], 2 * variance * kept);
  }
  return result;
}

} // namespace innergs
