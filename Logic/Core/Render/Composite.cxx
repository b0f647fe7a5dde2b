#include "Core/Render/Composite.h"

#include <bit>
#include <utility>

namespace innergs {
namespace {

/// Stable LSD radix sort of `ids` by `keys` (Knuth, TAOCP vol. 3, 5.2.5).
void radixSort(std::vector<std::uint32_t>& keys, std::span<std::uint32_t> ids) {
  static thread_local std::vector<std::uint32_t> otherKeys, otherIds;
  constexpr int kBits = 11, kDigits = 1 << kBits;
  const std::size_t n = ids.size();
  otherKeys.resize(n);
  otherIds.resize(n);
  std::uint32_t *k = keys.data(), *k2 = otherKeys.data(), *v = ids.data(), *v2 = otherIds.data();
  for (int shift = 0; shift < 33; shift += kBits) {
    std::uint32_t start[kDigits] = {};
    for (std::size_t i = 0; i < n; ++i)
      ++start[(k[i] >> shift) & (kDigits - 1)];
    std::uint32_t total = 0;
    for (std::uint32_t& s : start)
      total += std::exchange(s, total);
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t at = start[(k[i] >> shift) & (kDigits - 1)]++;
      k2[at] = k[i];
      v2[at] = v[i];
    }
    std::swap(k, k2);
    std::swap(v, v2);
  }
  if (v != ids.data()) std::copy_n(v, n, ids.data());
}

void sortByDepth(std::span<const Projected> gaussians, double z, std::span<std::uint32_t> ids) {
  static thread_local std::vector<std::uint32_t> keys;
  keys.resize(ids.size());
  for (std::size_t n = 0; n < ids.size(); ++n) // floats ≥ 0 sort like their bits
    keys[n] = std::bit_cast<std::uint32_t>(std::fabs(planeOffset(gaussians[ids[n]], z)));
  radixSort(keys, ids);
}

std::size_t tileSize(const TileRange& range, const GridView& grid) {
  return static_cast<std::size_t>(range.y1 - range.y0) * grid.stride;
}

std::size_t tileStart(const TileRange& range, const GridView& grid) {
  return (static_cast<std::size_t>(range.k0) * grid.ny + range.y0) * grid.stride;
}

} // namespace

void Compositor::forward(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool,
                         float* transmittance, float* image) {
  tiles_.bin(gaussians, grid, pool);
  pool.run(tiles_.count(), [&](std::int64_t t) {
    const TileRange range = tiles_.range(t, grid);
    std::fill_n(transmittance + tileStart(range, grid), tileSize(range, grid), 1.f);
    std::fill_n(image + tileStart(range, grid), tileSize(range, grid), 0.f);
    const auto members = tiles_.members(t);
    sortByDepth(gaussians, grid.z[range.k0], members);
    kernels_.composite(gaussians.data(), members.data(), members.size(), grid, range, transmittance, image);
  });
}

void Compositor::backward(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool,
                          const float* r, const float* image) {
  const std::int64_t n = static_cast<std::int64_t>(gaussians.size());
  first_.resize(n + 1);
  first_[0] = 0;
  for (std::int64_t i = 0; i < n; ++i)
    first_[i + 1] = first_[i] + tiles_.reach(i).count();
  slots_.resize(first_[n]);
  pool.run(tiles_.count(), [&](std::int64_t t) {
    static thread_local std::vector<float> seen, rest;
    static thread_local std::vector<math::PlaneMoments<float>> found;
    const TileRange range = tiles_.range(t, grid);
    const auto members = tiles_.members(t);
    const float* tile = image + tileStart(range, grid);
    seen.assign(tileSize(range, grid), 1.f);
    rest.assign(tile, tile + tileSize(range, grid));
    found.resize(members.size());
    kernels_.compositeBackward(gaussians.data(), members.data(), members.size(), grid, range, r, seen.data(),
                               rest.data(), found.data());
    const auto [tz, ty] = tiles_.position(t);
    for (std::size_t m = 0; m < members.size(); ++m) {
      const Tiles::Reach& reach = tiles_.reach(members[m]);
      slots_[first_[members[m]] + static_cast<std::int64_t>(tz - reach.z0) * (reach.y1 - reach.y0) + ty -
             reach.y0] = found[m];
    }
  });
}

math::Moments<float> Compositor::moments(std::span<const Projected> gaussians, const GridView& grid,
                                         std::int64_t i) const {
  math::Moments<float> sum;
  const Tiles::Reach& reach = tiles_.reach(i);
  std::int64_t slot = first_[i];
  for (int z = reach.z0; z < reach.z1; ++z) {
    const float dz = planeOffset(gaussians[i], grid.z[z]); // one plane per tile
    for (int y = reach.y0; y < reach.y1; ++y)
      math::addPlane(slots_[slot++], dz, sum);
  }
  return sum;
}

} // namespace innergs
