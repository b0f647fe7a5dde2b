#include "Core/Relocate.h"

#include "Core/GaussianMath.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace innergs {

void splitGaussian(const Gaussian& parent, double minLogScale, Gaussian& a, Gaussian& b) {
  float r[9];
  math::rotation(parent.quaternion, r);
  const int k = static_cast<int>(std::max_element(parent.logScale, parent.logScale + 3) - parent.logScale);
  const float offset = 0.6f * std::exp(parent.logScale[k]);
  a = b = parent;
  for (int i = 0; i < 3; ++i) {
    const float d = offset * r[3 * i + k];
    a.mean[i] += d;
    b.mean[i] -= d;
    const float shift = parent.slope[i] * d;
    a.intensity += shift;
    b.intensity -= shift;
  }
  a.logScale[k] = b.logScale[k] =
      std::max(parent.logScale[k] + std::log(0.7f), static_cast<float>(minLogScale));
}

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
    const Gaussian& g = field.gaussians[i];
    const float scale = std::exp((g.logScale[0] + g.logScale[1] + g.logScale[2]) / 3);
    const float* energy = adam.moment2.data() + 16 * i; // running mean of squared gradients
    need[i] = (energy[0] + energy[1] + energy[2]) * scale * scale;
    use[i] = energy[11];
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
    splitGaussian(field.gaussians[source], plan.minLogScale, a, b);
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
