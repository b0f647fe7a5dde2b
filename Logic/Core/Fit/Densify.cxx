#include "Core/Fit/Densify.h"

#include "Core/Fit/Relocate.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace innergs {
void GradientAccumulator::add(std::span<const float> gradient, const DensifyPlan& plan, ThreadPool& pool) {
  const std::int64_t n = static_cast<std::int64_t>(gradient.size() / 16);
  sum.resize(n, 0.f);
  ++iterations;
  const float unit = static_cast<float>(plan.voxel / plan.coverage);
  constexpr std::int64_t kBlock = 1 << 14;
  pool.runToEnd((n + kBlock - 1) / kBlock, [&](std::int64_t block) {
    for (std::int64_t i = block * kBlock; i < std::min(n, (block + 1) * kBlock); ++i) {
      const float* g = gradient.data() + 16 * i;
      sum[i] += unit * std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
    }
  });
}

void GradientAccumulator::clear() {
  sum.clear();
  iterations = 0;
}

reshape::Rules densifyRules(const DensifyPlan& plan, Blending blending, int iterations) {
  const DensifyThresholds& t = plan.thresholds;
  return {blending,
          t.opacity.value_or(0.01),
          static_cast<float>(std::log(t.size * plan.voxel)),
          static_cast<float>(t.gradient * std::max(1, iterations)),
          t.split * plan.voxel * plan.voxel,
          static_cast<float>(plan.minLogScale)};
}

DensifyCounts densifyGaussians(GaussianField& field, Adam& adam, GradientAccumulator& accumulator,
                               const DensifyPlan& plan) {
  DensifyCounts counts;
  const std::int64_t n = field.size();
  const reshape::Rules rules = densifyRules(plan, field.blending, accumulator.iterations);
  accumulator.sum.resize(n, 0.f);
  std::vector<std::uint32_t> kept;
  for (std::int64_t i = 0; i < n; ++i)
    if (!reshape::pruned(field.gaussians[i], rules)) kept.push_back(static_cast<std::uint32_t>(i));
  if (kept.empty()) return accumulator.clear(), counts; // an empty field could not be fitted any further
  counts.pruned = n - static_cast<std::int64_t>(kept.size());
  std::vector<std::uint32_t> growing;
  std::copy_if(kept.begin(), kept.end(), std::back_inserter(growing),
               [&](std::uint32_t i) { return accumulator.sum[i] > rules.gradient; });
  std::stable_sort(growing.begin(), growing.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return accumulator.sum[a] > accumulator.sum[b]; });
  const std::int64_t room = std::max<std::int64_t>(0, plan.limit - static_cast<std::int64_t>(kept.size()));
  if (static_cast<std::int64_t>(growing.size()) > room) growing.resize(room);
  accumulator.clear();
  if (counts.pruned == 0 && growing.empty()) return counts;

  std::vector<Gaussian> added(growing.size());
  for (std::size_t k = 0; k < growing.size(); ++k) {
    const std::ptrdiff_t at = 16 * static_cast<std::ptrdiff_t>(growing[k]);
    if (reshape::densify(field.gaussians[growing[k]], adam.moment1.data() + at, rules, added[k])) {
      std::fill_n(adam.moment1.begin() + at, 16, 0.f);
      std::fill_n(adam.moment2.begin() + at, 16, 0.f);
      ++counts.split;
    } else {
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
