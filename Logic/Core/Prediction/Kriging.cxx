#include "Core/Prediction/Kriging.h"

#include "Core/Base/Cholesky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace innergs {
namespace {

constexpr double kRange = 5;             // of the exponential
constexpr double kNugget = 1e-9;         // of the variance: keeps the equations well-conditioned
constexpr std::int64_t kNeighbours = 12; // slices on each side
constexpr int kPoints = 15;              // quadrature points of a box

} // namespace

Kriging::Kriging(double blur, SliceProfile profile, double thickness)
    : blur_(blur), thickness_(thickness), box_(profile == SliceProfile::Box && thickness > 0) {
  if (profile == SliceProfile::Gaussian) profileVariance_ = thickness * thickness / (8 * std::numbers::ln2);
  for (std::int64_t lag = 0; lag < 2 * kNeighbours; ++lag)
    lags_.push_back(betweenSlices(static_cast<double>(lag)));
  lags_[0] *= 1 + kNugget;
}

/// exp(−|d|/range) convolved with a Gaussian of the given variance.
double Kriging::covariance(double distance, double variance) const {
  const double d = std::abs(distance);
  if (variance < 1e-8) return std::exp(-d / kRange);
  const double s = std::sqrt(variance), mean = s / kRange;
  const auto half = [&](double sign) {
    const double x = (mean + sign * d / s) / std::numbers::sqrt2;
    return x > 26 ? 0 : std::exp(0.5 * mean * mean + sign * d / kRange) * std::erfc(x);
  };
  return 0.5 * (half(-1) + half(1));
}

double Kriging::seen(double distance) const {
  const double variance = 2 * blur_ * blur_ + profileVariance_;
  if (!box_) return covariance(distance, variance);
  double sum = 0;
  for (int n = 0; n < kPoints; ++n)
    sum += covariance(distance + thickness_ * ((n + 0.5) / kPoints - 0.5), variance);
  return sum / kPoints;
}

double Kriging::betweenSlices(double distance) const {
  const double variance = 2 * (blur_ * blur_ + profileVariance_);
  if (!box_) return covariance(distance, variance);
  double sum = 0;
  for (int n = 1 - kPoints; n < kPoints; ++n)
    sum += (kPoints - std::abs(n)) * covariance(distance + thickness_ * n / kPoints, variance);
  return sum / (kPoints * kPoints);
}

void Kriging::addWeights(double position, double share, std::span<double> row) const {
  if (!box_ && profileVariance_ == 0 && position == std::round(position)) {
    row[std::llround(position)] += share;
    return;
  }
  const auto slices = static_cast<std::int64_t>(row.size());
  const std::int64_t first =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(position)) + 1 - kNeighbours, 0,
                               std::max<std::int64_t>(0, slices - 2 * kNeighbours));
  const auto n = static_cast<int>(std::min(slices - first, 2 * kNeighbours));
  std::vector<double> square(static_cast<std::size_t>(n) * n), right(static_cast<std::size_t>(n) * 2);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j)
      square[i * n + j] = lags_[std::abs(i - j)];
    right[2 * i] = seen(position - static_cast<double>(first + i));
    right[2 * i + 1] = 1;
  }
  solveCholesky(square, right, n, 2);
  double sum = 0, ones = 0;
  for (int i = 0; i < n; ++i) {
    sum += right[2 * i];
    ones += right[2 * i + 1];
  }
  for (int i = 0; i < n; ++i)
    row[first + i] += share * (right[2 * i] + right[2 * i + 1] * (1 - sum) / ones);
}

} // namespace innergs
