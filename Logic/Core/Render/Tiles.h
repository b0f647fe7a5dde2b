#pragma once
#include "Core/Render/Kernels.h"

namespace innergs {

/// A grid divided into tiles (whole rows × some planes), each with the ascending list of Gaussians that
/// reach it. One task owns a tile, so a voxel's sum never depends on the number of threads.
class Tiles {
public:
  Tiles() = default;
  explicit Tiles(const GridView& grid, int planesPerTile = 8) { divide(grid, planesPerTile); }
  /// Divides another grid; its lists are empty until bin().
  void divide(const GridView& grid, int planesPerTile = 8);
  void bin(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool);

  std::int64_t count() const { return static_cast<std::int64_t>(tilesY_) * tilesZ_; }
  TileRange range(std::int64_t tile, const GridView& grid) const;
  std::span<const std::uint32_t> members(std::int64_t tile) const {
    return {ids_.data() + start_[tile], static_cast<std::size_t>(start_[tile + 1] - start_[tile])};
  }

  /// The tiles that a Gaussian reaches: planes [z0, z1) × rows [y0, y1) of tiles; empty if none.
  struct Reach {
    int z0 = 0, z1 = 0, y0 = 0, y1 = 0;
    std::int64_t count() const { return static_cast<std::int64_t>(z1 - z0) * (y1 - y0); }
  };
  const Reach& reach(std::int64_t gaussian) const { return reach_[gaussian]; } // of the last bin()
  /// A tile's position in the order of reach(): (tile in z, tile in y).
  std::pair<int, int> position(std::int64_t tile) const {
    return {static_cast<int>(tile / tilesY_), static_cast<int>(tile % tilesY_)};
  }
  std::span<std::uint32_t> members(std::int64_t tile) {
    return {ids_.data() + start_[tile], static_cast<std::size_t>(start_[tile + 1] - start_[tile])};
  }

private:
  Reach find(const Projected& gaussian, const GridView& grid) const;

  int rows_ = 1, planes_ = 1, tilesY_ = 0, tilesZ_ = 0;
  std::vector<std::int64_t> start_, cursor_;
  std::vector<std::uint32_t> ids_;
  std::vector<Reach> reach_;
};

} // namespace innergs
