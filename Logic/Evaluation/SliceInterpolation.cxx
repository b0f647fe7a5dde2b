#include "Evaluation/SliceInterpolation.h"

#include "Core/Base/Error.h"
#include "Evaluation/SeparableResample.h"

#include <algorithm>

namespace innergs {
namespace {

// The natural spline's value is linear in its samples, so its weights come from one solve with the transposed
// system.
std::vector<double> naturalSplineWeights(const std::vector<std::int64_t>& x, std::size_t low,
                                         double position) {
  const std::size_t n = x.size();
  const double h = double(x[low + 1] - x[low]), b = (position - double(x[low])) / h, a = 1 - b;
  std::vector<double> weights(n, 0.0);
  weights[low] = a;
  weights[low + 1] = b;
  if (n < 3) return weights;
  // Value = a y_low + b y_low+1 + cLow M_low + cHigh M_low+1, T M = B y with T symmetric, so weights += Bᵀ
  // T⁻¹ c.
  std::vector<double> diagonal(n - 2), upper(n - 2), solution(n - 2, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    diagonal[i - 1] = double(x[i + 1] - x[i - 1]) / 3;
    upper[i - 1] = double(x[i + 1] - x[i]) / 6;
  }
  if (low >= 1) solution[low - 1] = (a * a * a - a) * h * h / 6;
  if (low + 1 <= n - 2) solution[low] = (b * b * b - b) * h * h / 6;
  for (std::size_t i = 1; i < n - 2; ++i) {
    const double factor = upper[i - 1] / diagonal[i - 1];
    diagonal[i] -= factor * upper[i - 1];
    solution[i] -= factor * solution[i - 1];
  }
  for (std::size_t i = n - 2; i-- > 0;)
    solution[i] = (solution[i] - (i + 3 < n ? upper[i] * solution[i + 1] : 0)) / diagonal[i];
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = double(x[i] - x[i - 1]), after = double(x[i + 1] - x[i]), s = solution[i - 1];
    weights[i - 1] += s / before;
    weights[i] -= s * (1 / before + 1 / after);
    weights[i + 1] += s / after;
  }
  return weights;
}

} // namespace

std::vector<double> sliceWeights(const std::vector<std::int64_t>& kept, std::int64_t target,
                                 Interpolation kind) {
  if (kept.size() < 2)
    throw Error(ErrorCode::InvalidArgument, "Slice interpolation needs at least two kept slices.");
  std::vector<double> weights(kept.size(), 0.0);
  if (target <= kept.front() || target >= kept.back()) {
    (target <= kept.front() ? weights.front() : weights.back()) = 1;
    return weights;
  }
  const auto above = std::upper_bound(kept.begin(), kept.end(), target);
  const auto low = static_cast<std::size_t>(above - kept.begin()) - 1;
  const double f = double(target - kept[low]) / double(kept[low + 1] - kept[low]);
  if (kind == Interpolation::Cubic) return naturalSplineWeights(kept, low, double(target));
  if (kind == Interpolation::Linear) {
    weights[low] = 1 - f;
    weights[low + 1] = f;
    return weights;
  }
  const auto lanczos = lanczosWeights(f);
  for (int t = 0; t < 8; ++t) {
    const auto slice = std::clamp<std::int64_t>(static_cast<std::int64_t>(low) + t - 3, 0,
                                                static_cast<std::int64_t>(kept.size()) - 1);
    weights[static_cast<std::size_t>(slice)] += lanczos[t];
  }
  return weights;
}

Volume interpolateSlices(const Volume& volume, int axis, const std::vector<std::int64_t>& heldOut,
                         Interpolation kind) {
  const auto& n = volume.geometry.size;
  std::vector<std::int64_t> kept;
  for (std::int64_t k = 0; k < n[axis]; ++k)
    if (std::find(heldOut.begin(), heldOut.end(), k) == heldOut.end()) kept.push_back(k);
  const std::array<std::int64_t, 3> stride{1, n[0], n[0] * n[1]};
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  Volume result = volume;
  std::vector<double> sum(static_cast<std::size_t>(n[u] * n[v]));
  for (std::int64_t target : heldOut) {
    const std::vector<double> weights = sliceWeights(kept, target, kind);
    std::fill(sum.begin(), sum.end(), 0.0);
    const auto slice = [&](std::int64_t index, auto&& visit) {
      std::size_t s = 0;
      for (std::int64_t y = 0; y < n[v]; ++y)
        for (std::int64_t x = 0; x < n[u]; ++x, ++s)
          visit(static_cast<std::size_t>(index * stride[axis] + y * stride[v] + x * stride[u]), sum[s]);
    };
    for (std::size_t k = 0; k < kept.size(); ++k)
      if (std::abs(weights[k]) > 1e-9)
        slice(kept[k], [&](std::size_t p, double& value) { value += weights[k] * volume.voxels[p]; });
    slice(target, [&](std::size_t p, double& value) { result.voxels[p] = static_cast<float>(value); });
  }
  return result;
}

} // namespace innergs
