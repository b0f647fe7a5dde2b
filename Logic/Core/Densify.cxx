#include "Core/Densify.h"

#include "Core/Relocate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace innergs {
namespace {

double opacity(const Gaussian& g, Blending blending) {
  switch (blending) {
  case Blending::Alpha:
    return 1 / (1 + std::exp(-static_cast<double>(g.logWeight)));
  case Blending::Additive:
    return std::exp(static_cast<double>(g.logWeight)) * std::fabs(static_cast<double>(g.intensity));
  case Blending::Normalised:
    break;
  }
  return std::exp(static_cast<double>(g.logWeight));
}

float largestLogScale(const Gaussian& g) {
  return *std::max_element(g.logScale, g.logScale + 3);
}

double covarianceNorm(const Gaussian& g) {
  double sum = 0;
  for (float s : g.logScale)
    sum += std::exp(4 * static_cast<double>(s));
  return std::sqrt(sum);
}

/// The weight of each of two equal Gaussians that together blend as one did.
void shareWeight(Gaussian& g, Blending blending) {
  if (blending == Blending::Alpha) { // 1 − (1 − α′)² = α
    const double rest = std::sqrt(1 / (1 + std::exp(static_cast<double>(g.logWeight)))); // √(1 − α)
    g.logWeight = static_cast<float>(std::log1p(-rest) - std::log(rest));
  } else {
    g.logWeight -= 0.69314718f;
  }
}

/// One more, half the smallest σ away against the running mean of the gradient.
Gaussian cloned(Gaussian& original, const float* moment1, Blending blending) {
  shareWeight(original, blending);
  Gaussian copy = original;
  const double length =
      std::sqrt(static_cast<double>(moment1[0]) * moment1[0] + static_cast<double>(moment1[1]) * moment1[1] +
                static_cast<double>(moment1[2]) * moment1[2]);
  const double step =
      0.5 * std::exp(static_cast<double>(*std::min_element(copy.logScale, copy.logScale + 3)));
  if (length > 0)
    for (int a = 0; a < 3; ++a)
      copy.mean[a] -= static_cast<float>(step * moment1[a] / length);
  return copy;
}

} // namespace

void PullSum::add(std::span<const float> gradient, const DensifyPlan& plan, ThreadPool& pool) {
  const std::int64_t n = static_cast<std::int64_t>(gradient.size() / 16);
  sum.resize(n, 0.f);
  ++sweeps;
  const float unit = static_cast<float>(plan.voxel / plan.coverage);
  constexpr std::int64_t kBlock = 1 << 14;
  pool.runToEnd((n + kBlock - 1) / kBlock, [&](std::int64_t block) {
    for (std::int64_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) {
      const float* g = gradient.data() + 16 * i;
      sum[i] += unit * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    }
  });
}

void PullSum::clear() {
  sum.clear();
  sweeps = 0;
}

DensifyCounts densifyGaussians(GaussianField& field, Adam& adam, PullSum& pulls, const DensifyPlan& plan) {
  DensifyCounts counts;
  const DensifyThresholds& t = plan.thresholds;
  const std::int64_t n = field.size();
  const double faint = t.opacity.value_or(0.01);
  const float largest = static_cast<float>(std::log(t.size * plan.voxel));
  pulls.sum.resize(n, 0.f);
  std::vector<std::uint32_t> kept;
  for (std::int64_t i = 0; i < n; ++i) {
    const Gaussian& g = field.gaussians[i];
    if (opacity(g, field.blending) >= faint && largestLogScale(g) <= largest)
      kept.push_back(static_cast<std::uint32_t>(i));
  }
  if (kept.empty()) return pulls.clear(), counts; // a field of nothing could not be fitted any further
  counts.pruned = n - static_cast<std::int64_t>(kept.size());
  std::vector<std::uint32_t> pulled;
  const float gradient = static_cast<float>(t.gradient * std::max(1, pulls.sweeps));
  std::copy_if(kept.begin(), kept.end(), std::back_inserter(pulled),
               [&](std::uint32_t i) { return pulls.sum[i] > gradient; });
  std::stable_sort(pulled.begin(), pulled.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return pulls.sum[a] > pulls.sum[b]; });
  const std::int64_t room = std::max<std::int64_t>(0, plan.limit - static_cast<std::int64_t>(kept.size()));
  if (static_cast<std::int64_t>(pulled.size()) > room) pulled.resize(room);
  pulls.clear();
  if (counts.pruned == 0 && pulled.empty()) return counts;

  const auto restart = [&](std::uint32_t i) {
    std::fill_n(adam.moment1.begin() + 16 * static_cast<std::ptrdiff_t>(i), 16, 0.f);
    std::fill_n(adam.moment2.begin() + 16 * static_cast<std::ptrdiff_t>(i), 16, 0.f);
  };
  std::vector<Gaussian> added;
  const double splitAbove = t.split * plan.voxel * plan.voxel;
  for (std::uint32_t i : pulled) {
    Gaussian& g = field.gaussians[i];
    if (covarianceNorm(g) > splitAbove) {
      Gaussian a, b;
      splitGaussian(g, plan.minLogScale, a, b);
      // Two additive halves of 0.7 of the length would make the sum 1.4 times as large.
      if (field.blending == Blending::Additive)
        for (Gaussian* half : {&a, &b})
          half->logWeight -= 0.3364722f;
      g = a;
      added.push_back(b);
      restart(i);
      ++counts.split;
    } else {
      added.push_back(cloned(g, adam.moment1.data() + 16 * static_cast<std::size_t>(i), field.blending));
      ++counts.cloned;
    }
  }
  std::vector<std::uint32_t> order = std::move(kept);
  for (std::size_t k = 0; k < added.size(); ++k)
    order.push_back(static_cast<std::uint32_t>(n + static_cast<std::int64_t>(k)));
  field.gaussians.insert(field.gaussians.end(), added.begin(), added.end());
  adam.moment1.resize(16 * field.gaussians.size(), 0.f);
  adam.moment2.resize(16 * field.gaussians.size(), 0.f);
  takeInOrder(field, adam, order);
  takeInOrder(field, adam, mortonOrder(field.gaussians));
  return counts;
}

} // namespace innergs
