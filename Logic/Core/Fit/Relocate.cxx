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
  std::vector<float> need(n), use(n);
  for (std::int64_t i = 0; i < n; ++i) {
    const float* energy = adam.moment2.data() + 16 * i;
    need[i] = reshape::need(field.gaussians[i], energy);
    use[i] = reshape::use(energy);
  }
  std::vector<std::uint32_t> byNeed(n), byUse(n);
  std::iota(byNeed.begin(), byNeed.end(), 0u);
  byUse = byNeed;
  std::stable_sort(byNeed.begin(), byNeed.end(), [&](auto a, auto b) { return need[a] > need[b]; });
  std::stable_sort(byUse.begin(), byUse.end(), [&](auto a, auto b) { return use[a] < use[b]; });
  std::vector<std::uint8_t> parent(n, 0);
  for (std::int64_t i = 0; i < moved; ++i)
    parent[byNeed[i]] = 1;
  std::int64_t next = 0;
  for (std::int64_t i = 0, from = 0; i < n && from < moved; ++i) {
    const std::uint32_t victim = byUse[i];
    if (parent[victim]) continue;
    const std::uint32_t source = byNeed[from++];
    Gaussian a, b;
    reshape::split(field.gaussians[source], static_cast<float>(plan.minLogScale), a, b);
    field.gaussians[source] = a;
    field.gaussians[victim] = b;
    for (std::uint32_t id : {source, victim}) {
      std::fill_n(adam.moment1.begin() + 16 * id, 16, 0.f);
      std::fill_n(adam.moment2.begin() + 16 * id, 16, 0.f);
    }
    ++next;
  }
  if (next == 0) return;
  takeInOrder(field, adam, mortonOrder(field.gaussians));
}

} // namespace innergs
