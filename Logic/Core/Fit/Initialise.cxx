#include "Core/Fit/Initialise.h"

#include "Core/Base/Random.h"
#include "Core/Image/Region.h"
#include "Core/Model/Morton.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace innergs {
namespace {

/// Mean of the covered voxels around a continuous index, with trilinear weights.
float proxyValue(const ProxyVolume& proxy, const Vec3& index) {
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

/// Cells of equal size over a block of voxels, shifted cyclically.
struct CellGrid {
  std::array<std::int64_t, 3> first, n;
  Vec3 extent; // mm
  double shift[3];

  double cell(int axis) const { return extent[axis] / static_cast<double>(n[axis]); }
  std::int64_t count() const { return n[0] * n[1] * n[2]; }

  /// Calls visit(index) for the centre of every cell that lies in a covered voxel.
  template <class Visit>
  void forEachCovered(const ProxyVolume& proxy, const Visit& visit) const {
    const GridGeometry& g = proxy.geometry;
    for (std::int64_t k = 0; k < n[2]; ++k)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i) {
          const std::int64_t at[3] = {i, j, k};
          Vec3 index;
          std::size_t voxel = 0, step = 1;
          for (int a = 0; a < 3; ++a) {
            index[a] = static_cast<double>(first[a]) +
                       ((std::fmod(static_cast<double>(at[a]) + 0.5 + shift[a], static_cast<double>(n[a]))) *
                            cell(a) / g.spacing[a] -
                        0.5);
            const auto nearest = std::clamp<std::int64_t>(std::llround(index[a]), 0, g.size[a] - 1);
            voxel += step * nearest;
            step *= g.size[a];
          }
          if (proxy.covered[voxel]) visit(index);
        }
  }
};

void evenGrid(GaussianField& field, const ProxyVolume& proxy, const InitialisationPlan& plan,
              std::uint64_t seed) {
  const GridGeometry& g = proxy.geometry;
  const auto box = filledBlock(proxy.geometry.size, proxy.covered);
  if (!box) return;
  const auto covered =
      std::count_if(proxy.covered.begin(), proxy.covered.end(), [](auto c) { return c != 0; });
  const bool layered = plan.layerSpacing > 0;
  CellGrid grid{box->first, {}, {}, {}};
  std::array<std::int64_t, 3> voxels = box->size;
  if (layered) { // one layer for every slice of the whole stack, covered or not
    grid.first[2] = 0;
    voxels[2] = g.size[2];
  }
  for (int a = 0; a < 3; ++a)
    grid.extent[a] = g.spacing[a] * static_cast<double>(voxels[a]);
  const Vec3& extent = grid.extent;
  // The budget is for the covered part: cells outside it do not count.
  const double share = static_cast<double>(covered) / static_cast<double>(voxels[0] * voxels[1] * voxels[2]);
  // As close to cubes as whole numbers allow; layers keep their own spacing along the third axis.
  double cell[3];
  if (layered) {
    const double layers = std::max(1.0, std::round(extent[2] / plan.layerSpacing));
    cell[0] = cell[1] =
        std::sqrt(extent[0] * extent[1] * layers * share / static_cast<double>(plan.gaussians));
    cell[2] = extent[2] / layers;
  } else {
    cell[0] = cell[1] = cell[2] =
        std::cbrt(extent[0] * extent[1] * extent[2] * share / static_cast<double>(plan.gaussians));
  }
  // Each seed shifts the grid in-plane (Roberts' quasi-random sequence, 2018); the first one is centred.
  const double phase = static_cast<double>((seed - 1) % 4096);
  grid.shift[0] = std::fmod(0.7548776662466927 * phase, 1.0);
  grid.shift[1] = std::fmod(0.5698402909980532 * phase, 1.0);
  const auto perAxis =
      static_cast<std::int64_t>(std::cbrt(static_cast<double>(plan.gaussians) / share) + 1e-6);
  for (int a = 0; a < 3; ++a)
    grid.n[a] = std::max<std::int64_t>(1, plan.equalCounts ? perAxis : std::llround(extent[a] / cell[a]));
  const auto placed = [&] {
    if (share == 1) return grid.count();
    std::int64_t count = 0;
    grid.forEachCovered(proxy, [&](const Vec3&) { ++count; });
    return count;
  };
  while (placed() > plan.gaussians) { // widens the narrowest cells
    int narrow = -1;
    for (int a = 0; a < (layered ? 2 : 3); ++a)
      if (grid.n[a] > 1 && (narrow < 0 || extent[a] * static_cast<double>(grid.n[narrow]) <
                                              extent[narrow] * static_cast<double>(grid.n[a])))
        narrow = a;
    if (narrow < 0) break;
    --grid.n[narrow];
  }
  Vec3 sigma{plan.scaleFactor * grid.cell(0), plan.scaleFactor * grid.cell(1),
             plan.scaleFactor * grid.cell(2)};
  if (layered) sigma[2] = plan.layerSigma;
  grid.forEachCovered(proxy,
                      [&](const Vec3& index) { field.gaussians.push_back(gaussianAt(proxy, index, sigma)); });
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
  // Systematic sampling along a Morton curve of bricks: stratified in space, and already in the field's
  // order.
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

/// Marks voxels within `reach` mm of a covered voxel, from centre to centre.
std::vector<std::uint8_t> within(const ProxyVolume& proxy, double reach, ThreadPool& pool) {
  const GridGeometry& g = proxy.geometry;
  std::int64_t most[3];
  for (int a = 0; a < 3; ++a)
    most[a] = static_cast<std::int64_t>(reach / g.spacing[a]);
  std::vector<std::vector<std::array<std::int64_t, 2>>> ball(2 * most[2] + 1); // by slice
  for (std::int64_t k = -most[2]; k <= most[2]; ++k)
    for (std::int64_t j = -most[1]; j <= most[1]; ++j)
      for (std::int64_t i = -most[0]; i <= most[0]; ++i)
        if (norm({static_cast<double>(i) * g.spacing[0], static_cast<double>(j) * g.spacing[1],
                  static_cast<double>(k) * g.spacing[2]}) <= reach)
          ball[k + most[2]].push_back({i, j});
  std::vector<std::uint8_t> marked(proxy.covered.size(), 0);
  const auto& n = g.size;
  pool.run(n[2], [&](std::int64_t k) { // each task marks its own slice
    for (std::int64_t from = std::max<std::int64_t>(0, k - most[2]); from <= std::min(n[2] - 1, k + most[2]);
         ++from)
      for (std::int64_t j = 0; j < n[1]; ++j)
        for (std::int64_t i = 0; i < n[0]; ++i) {
          if (!proxy.covered[i + n[0] * (j + n[1] * from)]) continue;
          for (const auto& by : ball[k - from + most[2]]) {
            const std::int64_t x = i + by[0], y = j + by[1];
            if (x >= 0 && x < n[0] && y >= 0 && y < n[1]) marked[x + n[0] * (y + n[1] * k)] = 1;
          }
        }
  });
  return marked;
}

constexpr double kShareVoxels = 4e6; // at most, roughly: enough to locate the structure
// Gaussians next to a mask fit its border as well. Chosen on masks of a brain, bones, a liver and labels so
// that none loses more than 0.3 dB.
constexpr double kReach = 0.6;

} // namespace

ReachedShare reachedShare(std::span<const Stack> stacks, const IntensityMap& map,
                          const InitialisationPlan& start, double volume, double voxel, ThreadPool& pool) {
  const bool whole = std::all_of(stacks.begin(), stacks.end(), [](const Stack& stack) {
    for (std::size_t v = 0; v < stack.observed.size(); ++v)
      if (!stack.observed[v] && std::isfinite(stack.image.voxels[v])) return false;
    return true;
  });
  if (whole) return {};
  // With several stacks, the frame does not depend on their order.
  const Affine3 frame = stacks.size() > 1 ? Affine3{} : Affine3{stacks.front().image.geometry.direction, {}};
  const auto gaussians = static_cast<double>(start.gaussians);
  const double distance = start.layerSpacing > 0 ? std::sqrt(volume / start.layerSpacing / gaussians)
                                                 : std::cbrt(volume / gaussians);
  const double reach = kReach * distance;
  const double spacing = std::max(voxel, std::min(reach, std::cbrt(volume / kShareVoxels)));
  const ProxyVolume observed = makeProxy(stacks, frame, map, spacing, pool);
  const std::vector<std::uint8_t> reached = within(observed, reach, pool);
  const ProxyVolume all = makeProxy(stacks, frame, map, spacing, pool, Voxels::All);
  const std::vector<float> structure = structureMeasure(all, pool);
  double sum = 0, sumReached = 0;
  std::int64_t voxels = 0, voxelsReached = 0;
  for (std::size_t v = 0; v < structure.size(); ++v) {
    if (!all.covered[v]) continue;
    const double follows = std::pow(static_cast<double>(structure[v]), start.exponent);
    sum += follows;
    ++voxels;
    if (!reached[v]) continue;
    sumReached += follows;
    ++voxelsReached;
  }
  if (voxels == 0) return {};
  const double byVolume = static_cast<double>(voxelsReached) / static_cast<double>(voxels);
  if (start.kind != Initialisation::Adaptive || sum <= 0) return {byVolume, byVolume};
  return {std::max(byVolume, start.evenShare * byVolume + (1 - start.evenShare) * sumReached / sum),
          byVolume};
}

std::vector<float> structureMeasure(const ProxyVolume& proxy, ThreadPool& pool) {
  const auto& size = proxy.geometry.size;
  const std::int64_t step[3] = {1, size[0], size[0] * size[1]};
  std::vector<float> measure(proxy.voxels.size()), smooth(proxy.voxels.size());
  pool.run(size[2], [&](std::int64_t k) {
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const std::int64_t at[3] = {i, j, k}, v = i * step[0] + j * step[1] + k * step[2];
        if (!proxy.covered[v]) continue;
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
  for (int a = 0; a < 3; ++a) { // binomial 1-4-6-4-1 along each axis over the covered voxels, edges clamped
    pool.run(size[2], [&](std::int64_t k) {
      for (std::int64_t j = 0; j < size[1]; ++j)
        for (std::int64_t i = 0; i < size[0]; ++i) {
          const std::int64_t at[3] = {i, j, k}, v = i * step[0] + j * step[1] + k * step[2];
          static constexpr float w[5] = {1 / 16.f, 4 / 16.f, 6 / 16.f, 4 / 16.f, 1 / 16.f};
          if (!proxy.covered[v]) continue;
          float sum = 0, total = 0;
          for (int o = -2; o <= 2; ++o) {
            const std::int64_t from =
                v + step[a] * (std::clamp<std::int64_t>(at[a] + o, 0, size[a] - 1) - at[a]);
            if (!proxy.covered[from]) continue;
            sum += w[o + 2] * measure[from];
            total += w[o + 2];
          }
          smooth[v] = sum / total;
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
  if (plan.kind == Initialisation::Grid || plan.layerSpacing > 0) evenGrid(field, proxy, plan, seed);
  // If the covered part slips between all cells of a grid, as a thin shell can, it is sampled evenly.
  InitialisationPlan drawn = plan;
  if (drawn.kind == Initialisation::Grid) drawn.evenShare = 1;
  if (field.gaussians.empty()) adaptive(field, proxy, drawn, seed, pool);
  if (field.blending == Blending::Additive) {
    // Overlapping Gaussians of unit height sum to about (2π)^1.5·scaleFactor³ times their density.
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
