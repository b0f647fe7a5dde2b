#include "Core/Initialise.h"

#include "Core/Morton.h"
#include "Core/Random.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace innergs {
namespace {

/// Mean of the covered voxels around a continuous index (trilinear).
float proxyValue(const ProxyVolume& proxy, const Vec3& index) {
  const Volume view{proxy.geometry, {}};
  const auto& size = proxy.geometry.size;
  std::int64_t base[3];
  double f[3];
  for (int a = 0; a < 3; ++a) {
    const double x = std::clamp(index[a], 0.0, static_cast<double>(size[a] - 1));
    base[a] = std::min<std::int64_t>(static_cast<std::int64_t>(x), std::max<std::int64_t>(0, size[a] - 2));
    f[a] = x - static_cast<double>(base[a]);
  }
  double sum = 0, total = 1e-12;
  for (int c = 0; c < 8; ++c) {
    const std::int64_t i = base[0] + (c & 1), j = base[1] + ((c >> 1) & 1), k = base[2] + (c >> 2);
    if (i >= size[0] || j >= size[1] || k >= size[2]) continue;
    const std::size_t v = i + size[0] * (j + size[1] * k);
    if (!proxy.covered[v]) continue;
    const double w = ((c & 1) ? f[0] : 1 - f[0]) * ((c & 2) ? f[1] : 1 - f[1]) * ((c & 4) ? f[2] : 1 - f[2]);
    sum += w * proxy.voxels[v];
    total += w;
  }
  return static_cast<float>(sum / total);
}

Gaussian gaussianAt(const ProxyVolume& proxy, const Vec3& index, const Vec3& sigma) {
  Gaussian g{};
  for (int a = 0; a < 3; ++a) {
    g.mean[a] = static_cast<float>(proxy.geometry.origin[a] + proxy.geometry.spacing[a] * index[a]);
    g.logScale[a] = static_cast<float>(std::log(sigma[a]));
  }
  g.quaternion[0] = 1;
  g.intensity = proxyValue(proxy, index);
  return g;
}

void evenGrid(GaussianField& field, const ProxyVolume& proxy, const InitialisationPlan& plan,
              std::uint64_t seed) {
  const GridGeometry& g = proxy.geometry;
  const Vec3 extent = g.extent();
  // Cubes as far as whole numbers allow; layers keep their own spacing along the third axis.
  const bool layered = plan.layerSpacing > 0;
  double cell[3];
  if (layered) {
    const double layers = std::max(1.0, std::round(extent[2] / plan.layerSpacing));
    cell[0] = cell[1] = std::sqrt(extent[0] * extent[1] * layers / static_cast<double>(plan.gaussians));
    cell[2] = extent[2] / layers;
  } else {
    cell[0] = cell[1] = cell[2] =
        std::cbrt(extent[0] * extent[1] * extent[2] / static_cast<double>(plan.gaussians));
  }
  // Another seed shifts the grid in-plane (additive recurrence: well spread); the first starts centred.
  const double phase = static_cast<double>((seed - 1) % 4096);
  const double shift[3] = {std::fmod(0.7548776662466927 * phase, 1.0),
                           std::fmod(0.5698402909980532 * phase, 1.0), 0};
  std::int64_t n[3];
  const auto perAxis = static_cast<std::int64_t>(std::cbrt(static_cast<double>(plan.gaussians)) + 1e-6);
  for (int a = 0; a < 3; ++a)
    n[a] = std::max<std::int64_t>(1, plan.equalCounts ? perAxis : std::llround(extent[a] / cell[a]));
  while (n[0] * n[1] * n[2] > plan.gaussians) { // widen the narrowest cells
    int narrow = -1;
    for (int a = 0; a < (layered ? 2 : 3); ++a)
      if (n[a] > 1 && (narrow < 0 || extent[a] * static_cast<double>(n[narrow]) <
                                         extent[narrow] * static_cast<double>(n[a])))
        narrow = a;
    if (narrow < 0) break;
    --n[narrow];
  }
  for (int a = 0; a < 3; ++a)
    cell[a] = extent[a] / static_cast<double>(n[a]);
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i) {
        const std::int64_t at[3] = {i, j, k};
        Vec3 index;
        bool covered = true;
        std::size_t voxel = 0, step = 1;
        for (int a = 0; a < 3; ++a) {
          index[a] = (std::fmod(static_cast<double>(at[a]) + 0.5 + shift[a], static_cast<double>(n[a]))) *
                         cell[a] / g.spacing[a] -
                     0.5;
          const auto nearest = std::clamp<std::int64_t>(std::llround(index[a]), 0, g.size[a] - 1);
          voxel += step * nearest;
          step *= g.size[a];
        }
        covered = proxy.covered[voxel] != 0;
        if (!covered) continue;
        Vec3 sigma{plan.scaleFactor * cell[0], plan.scaleFactor * cell[1], plan.scaleFactor * cell[2]};
        if (layered) sigma[2] = plan.layerSigma;
        field.gaussians.push_back(gaussianAt(proxy, index, sigma));
      }
}

void adaptive(GaussianField& field, const ProxyVolume& proxy, const InitialisationPlan& plan,
              std::uint64_t seed, ThreadPool& pool) {
  const auto& size = proxy.geometry.size;
  std::vector<float> density = structureMeasure(proxy, pool);
  double structure = 0;
  std::int64_t covered = 0;
  pool.blocks(static_cast<std::int64_t>(density.size()), 1 << 16, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t v = first; v < last; ++v)
      density[v] = proxy.covered[v] ? std::pow(density[v], static_cast<float>(plan.exponent)) : 0.f;
  });
  for (std::size_t v = 0; v < density.size(); ++v) {
    structure += density[v];
    covered += proxy.covered[v];
  }
  if (covered == 0) return;
  const double n = static_cast<double>(plan.gaussians);
  const double even = (structure > 0 ? plan.evenShare : 1.0) * n / static_cast<double>(covered);
  const double following = structure > 0 ? (1 - plan.evenShare) * n / structure : 0;
  // Systematic sampling along a Morton curve of bricks: stratified in space, and sorted as the field wants to
  // be.
  Random random(seed);
  double position = random.uniform();
  constexpr int kBrick = 8;
  std::vector<std::array<std::int64_t, 3>> bricks;
  for (std::int64_t k = 0; k < size[2]; k += kBrick)
    for (std::int64_t j = 0; j < size[1]; j += kBrick)
      for (std::int64_t i = 0; i < size[0]; i += kBrick)
        bricks.push_back({i, j, k});
  std::sort(bricks.begin(), bricks.end(),
            [](const auto& a, const auto& b) { return morton(a[0], a[1], a[2]) < morton(b[0], b[1], b[2]); });
  std::array<std::array<int, 3>, kBrick * kBrick * kBrick> inside;
  for (int c = 0; c < static_cast<int>(inside.size()); ++c)
    inside[morton(c % kBrick, c / kBrick % kBrick, c / kBrick / kBrick)] = {c % kBrick, c / kBrick % kBrick,
                                                                            c / kBrick / kBrick};
  const Vec3& spacing = proxy.geometry.spacing;
  for (const auto& brick : bricks) {
    pool.throwIfStopped();
    for (const auto& in : inside) {
      const std::int64_t i = brick[0] + in[0], j = brick[1] + in[1], k = brick[2] + in[2];
      if (i >= size[0] || j >= size[1] || k >= size[2]) continue;
      const std::size_t v = i + size[0] * (j + size[1] * k);
      if (!proxy.covered[v]) continue;
      const double rho = even + following * density[v]; // Gaussians per voxel
      position += rho;
      for (; position >= 1; position -= 1) {
        const Vec3 index{static_cast<double>(i) + random.uniform() - 0.5,
                         static_cast<double>(j) + random.uniform() - 0.5,
                         static_cast<double>(k) + random.uniform() - 0.5};
        const double local = std::clamp(std::cbrt(1 / rho), 0.8, 24.0) * plan.scaleFactor;
        field.gaussians.push_back(
            gaussianAt(proxy, index, {local * spacing[0], local * spacing[1], local * spacing[2]}));
      }
    }
  }
}

} // namespace

std::vector<float> structureMeasure(const ProxyVolume& proxy, ThreadPool& pool) {
  const auto& size = proxy.geometry.size;
  const std::int64_t step[3] = {1, size[0], size[0] * size[1]};
  std::vector<float> measure(proxy.voxels.size()), smooth(proxy.voxels.size());
  pool.run(size[2], [&](std::int64_t k) {
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const std::int64_t at[3] = {i, j, k}, v = i * step[0] + j * step[1] + k * step[2];
        float gradient = 0, second = 0;
        for (int a = 0; a < 3; ++a) {
          const std::int64_t low = at[a] > 0 && proxy.covered[v - step[a]] ? v - step[a] : v;
          const std::int64_t high = at[a] + 1 < size[a] && proxy.covered[v + step[a]] ? v + step[a] : v;
          const float l = proxy.voxels[low], h = proxy.voxels[high];
          gradient += (h - l) * (h - l) * 0.25f;
          second += std::fabs(h + l - 2 * proxy.voxels[v]);
        }
        measure[v] = 0.5f * std::sqrt(gradient) + second;
      }
  });
  for (int a = 0; a < 3; ++a) { // binomial 1-4-6-4-1 along each axis, edges clamped
    pool.run(size[2], [&](std::int64_t k) {
      for (std::int64_t j = 0; j < size[1]; ++j)
        for (std::int64_t i = 0; i < size[0]; ++i) {
          const std::int64_t at[3] = {i, j, k}, v = i * step[0] + j * step[1] + k * step[2];
          static constexpr float w[5] = {1 / 16.f, 4 / 16.f, 6 / 16.f, 4 / 16.f, 1 / 16.f};
          float sum = 0;
          for (int o = -2; o <= 2; ++o)
            sum += w[o + 2] *
                   measure[v + step[a] * (std::clamp<std::int64_t>(at[a] + o, 0, size[a] - 1) - at[a])];
          smooth[v] = sum;
        }
    });
    measure.swap(smooth);
  }
  return measure;
}

std::vector<std::uint32_t> mortonOrder(std::span<const Gaussian> gaussians) {
  std::vector<std::uint32_t> order(gaussians.size());
  std::iota(order.begin(), order.end(), 0u);
  if (order.empty()) return order;
  MeanBox box = MeanBox::empty();
  for (const Gaussian& g : gaussians)
    box.add(g.mean, g.mean);
  std::vector<std::uint64_t> code(order.size());
  for (std::size_t i = 0; i < code.size(); ++i)
    code[i] = mortonCode(gaussians[i], box);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return code[a] < code[b]; });
  return order;
}

std::vector<Gaussian> inMortonOrder(std::vector<Gaussian> gaussians) {
  std::vector<Gaussian> sorted;
  sorted.reserve(gaussians.size());
  for (std::uint32_t i : mortonOrder(gaussians))
    sorted.push_back(gaussians[i]);
  return sorted;
}

void initialise(GaussianField& field, const ProxyVolume& proxy, const InitialisationPlan& plan,
                std::uint64_t seed, ThreadPool& pool) {
  field.gaussians.clear();
  field.gaussians.reserve(plan.gaussians + plan.gaussians / 16 + 16);
  if (plan.kind == Initialisation::Grid || plan.layerSpacing > 0)
    evenGrid(field, proxy, plan, seed);
  else
    adaptive(field, proxy, plan, seed, pool);
  if (field.blending == Blending::Additive) {
    // Overlapping unit Gaussians sum to about (2π)^1.5·scaleFactor³ times their density.
    const float overlap =
        static_cast<float>(std::pow(2 * 3.14159265358979, 1.5) * std::pow(plan.scaleFactor, 3));
    for (Gaussian& g : field.gaussians)
      g.intensity /= overlap;
  }
  if (field.blending == Blending::Alpha)
    for (Gaussian& g : field.gaussians)
      g.logWeight = 0; // α = ½
  field.gaussians = inMortonOrder(std::move(field.gaussians));
}

} // namespace innergs
