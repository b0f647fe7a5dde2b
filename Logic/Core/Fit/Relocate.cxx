#include "Core/Fit/Relocate.h"

#include "Core/Fit/Reshape.h"

#include <algorithm>
#include <numeric>

namespace innergs {

void takeInOrder(GaussianField& field, Adam& adam, std::span<const std::uint32_t> order) {
  std::vector<Gaussian> sorted(order.size());
  std::vector<float> m1(16 * order.size()), m2(16 * order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const std::size_t from = order[i];
    sorted[i] = field.gaussians[from];
    std::copy_n(adam.moment1.begin() + 16 * from, 16, m1.begin() + 16 * i);
    std::copy_n(adam.moment2.begin() + 16 * from, 16, m2.begin() + 16 * i);
  }
  field.gaussians = std::move(sorted);
  adam.moment1 = std::move(m1);
  adam.moment2 = std::move(m2);
}

void relocateGaussians(GaussianField& field, Adam& adam, const RelocationPlan& plan) {
  const std::int64_t n = field.size(), moved = static_cast<std::int64_t>(plan.share * static_cast<double>(n));
  if (moved < 1) return;
  std::vector<float> priority(n), influence(n);
  for (std::int64_t i = 0; i < n; ++i) {
    const float* energy = adam.moment2.data() + 16 * i;
    priority[i] = reshape::splitPriority(field.gaussians[i], energy);
    influence[i] = reshape::influence(energy);
  }
  std::vector<std::uint32_t> byPriority(n), byInfluence(n);
  std::iota(byPriority.begin(), byPriority.end(), 0u);
  byInfluence = byPriority;
  std::stable_sort(byPriority.begin(), byPriority.end(),
                   [&](auto a, auto b) { return priority[a] > priority[b]; });
  std::stable_sort(byInfluence.begin(), byInfluence.end(),
                   [&](auto a, auto b) { return influence[a] < influence[b]; });
  std::vector<std::uint8_t> parent(n, 0);
  for (std::int64_t i = 0; i < moved; ++i)
    parent[byPriority[i]] = 1;
  std::int64_t next = 0;
  for (std::int64_t i = 0, from = 0; i < n && from < moved; ++i) {
    const std::uint32_t replaced = byInfluence[i];
    if (parent[replaced]) continue;
    const std::uint32_t source = byPriority[from++];
    Gaussian a, b;
    reshape::split(field.gaussians[source], static_cast<float>(plan.minLogScale), a, b);
    field.gaussians[source] = a;
    field.gaussians[replaced] = b;
    for (std::uint32_t id : {source, replaced}) {
      std::fill_n(adam.moment1.begin() + 16 * id, 16, 0.f);
      std::fill_n(adam.moment2.begin() + 16 * id, 16, 0.f);
    }
    ++next;
  }
  if (next == 0) return;
  takeInOrder(field, adam, mortonOrder(field.gaussians));
}

} // namespace innergs
