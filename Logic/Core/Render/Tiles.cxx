#include "Core/Render/Tiles.h"

namespace innergs {
namespace {
constexpr std::int64_t kGaussiansPerTask = 8192; // fixed, so the order never depends on the threads
} // namespace

void Tiles::divide(const GridView& grid, int planesPerTile) {
  planes_ = std::min(planesPerTile, grid.nz);
  tilesZ_ = (grid.nz + planes_ - 1) / planes_;
  rows_ = tilesZ_ >= 12 ? std::max(1, grid.ny) : std::clamp(grid.ny * tilesZ_ / 24, 32, 64);
  tilesY_ = (grid.ny + rows_ - 1) / rows_;
}

TileRange Tiles::range(std::int64_t tile, const GridView& grid) const {
  const int ty = static_cast<int>(tile % tilesY_), tz = static_cast<int>(tile / tilesY_);
  return {ty * rows_, std::min(grid.ny, (ty + 1) * rows_), tz * planes_,
          std::min(grid.nz, (tz + 1) * planes_)};
}

Tiles::Reach Tiles::find(const Projected& g, const GridView& grid) const {
  const double x = g.cell[0] + static_cast<double>(g.fraction[0]),
               y = g.cell[1] + static_cast<double>(g.fraction[1]);
  if (!(x + g.half[0] >= 0 && x - g.half[0] <= grid.nx - 1)) return {};
  if (!(y + g.half[1] >= 0 && y - g.half[1] <= grid.ny - 1)) return {};
  int k0, k1;
  planeRange(g, grid, k0, k1);
  if (k0 >= k1) return {};
  const int y0 = static_cast<int>(std::max(0.0, std::ceil(y - g.half[1]))) / rows_;
  const int y1 = static_cast<int>(std::min<double>(grid.ny - 1, std::floor(y + g.half[1]))) / rows_;
  return {k0 / planes_, (k1 - 1) / planes_ + 1, y0, std::max(y0, y1 + 1)};
}

void Tiles::bin(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool) {
  const std::int64_t n = static_cast<std::int64_t>(gaussians.size()),
                     blocks = (n + kGaussiansPerTask - 1) / kGaussiansPerTask;
  const std::int64_t tiles = count();
  cursor_.assign(blocks * tiles, 0);
  reach_.resize(n);
  const auto visit = [&](std::int64_t i, auto&& each) {
    const Reach& r = reach_[i];
    for (int tz = r.z0; tz < r.z1; ++tz)
      for (int ty = r.y0; ty < r.y1; ++ty)
        each(static_cast<std::int64_t>(tz) * tilesY_ + ty);
  };
  pool.run(blocks, [&](std::int64_t b) {
    std::int64_t* counts = cursor_.data() + b * tiles;
    for (std::int64_t i = b * kGaussiansPerTask; i < std::min(n, (b + 1) * kGaussiansPerTask); ++i) {
      reach_[i] = find(gaussians[i], grid);
      visit(i, [&](std::int64_t t) { ++counts[t]; });
    }
  });
  start_.assign(tiles + 1, 0);
  std::int64_t total = 0;
  for (std::int64_t t = 0; t < tiles; ++t) {
    start_[t] = total;
    for (std::int64_t b = 0; b < blocks; ++b) {
      std::int64_t& cursor = cursor_[b * tiles + t];
      const std::int64_t here = cursor;
      cursor = total;
      total += here;
    }
  }
  start_[tiles] = total;
  ids_.resize(total);
  pool.run(blocks, [&](std::int64_t b) {
    std::int64_t* cursor = cursor_.data() + b * tiles;
    for (std::int64_t i = b * kGaussiansPerTask; i < std::min(n, (b + 1) * kGaussiansPerTask); ++i)
      visit(i, [&](std::int64_t t) { ids_[cursor[t]++] = static_cast<std::uint32_t>(i); });
  });
}

} // namespace innergs
