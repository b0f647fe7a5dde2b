#pragma once
#include "Cuda/Block.h"
#include "Cuda/Kernels/Reach.h"

namespace innergs::cuda {

/// W = Σ w p and N = Σ w p (c + g·d), one brick per block: each thread owns a column of four points, each
/// warp 8×4 columns, and a warp visits only the staged Gaussians whose box meets them.
struct Accumulate {
  static constexpr int kThreads = 128, kBatch = 64, kGroups = kBatch / kWarp;
  static constexpr int kPlanes = BrickReach::kZ;
  /// The data of a column in the order of use, read 16 bytes at a time.
  struct alignas(16) Staged {
    float cell[2]; // relative to the brick's first point: subtracting floats is cheaper than converting
    float fraction[2], quadratic[6], log2Weight, log2Cut, value, slope[3], dz[kPlanes], cut;
  };
  struct Shared {
    Staged staged[kBatch];
    float centre[2][kBatch], half[2][kBatch]; // separate: a warp reads one of each without bank conflicts
  };
  const Projected* gaussians;
  BrickReach bricks;
  const std::int64_t* start;
  const std::uint32_t* ids;
  Pair* out;

  INNERGS_HD static void stage(const Projected& g, const GridView& grid, int x0, int y0, int k0, int n,
                               Shared& shared) {
    Staged& s = shared.staged[n];
    const int low[2] = {x0, y0};
    for (int a = 0; a < 2; ++a) {
      s.cell[a] = static_cast<float>(g.cell[a] - low[a]);
      s.fraction[a] = g.fraction[a];
      shared.centre[a][n] = s.cell[a] + g.fraction[a];
      shared.half[a][n] = g.half[a];
    }
    for (int i = 0; i < 6; ++i)
      s.quadratic[i] = g.quadratic[i];
    s.log2Weight = g.log2Weight;
    s.log2Cut = g.log2Cut;
    s.cut = g.cut;
    s.value = g.value;
    for (int i = 0; i < 3; ++i)
      s.slope[i] = g.slope[i];
    INNERGS_UNROLL
    for (int j = 0; j < kPlanes; ++j)
      s.dz[j] = planeOffset(g, grid.z[k0 + j < grid.nz ? k0 + j : grid.nz - 1]);
  }

  /// low: relative to the brick's first point.
  INNERGS_HD static bool meets(const Shared& shared, int n, int axis, int low, int width) {
    const float at = shared.centre[axis][n] - static_cast<float>(low), half = shared.half[axis][n];
    return at + half >= 0 && at - half <= static_cast<float>(width - 1);
  }

  INNERGS_HD static void add(const Staged& s, float x, float y, Lanes<float, 2 * kPlanes>& sums) {
    const float dx = x - s.cell[0] - s.fraction[0], dy = y - s.cell[1] - s.fraction[1];
    const float* q = s.quadratic;
    const float e0 = q[0] * dx * dx + q[1] * dx * dy + q[3] * dy * dy + s.log2Weight;
    const float e1 = q[2] * dx + q[4] * dy, value = s.value + s.slope[0] * dx + s.slope[1] * dy;
    INNERGS_UNROLL
    for (int j = 0; j < kPlanes; ++j) {
      const float dz = s.dz[j], e = e0 + dz * (e1 + q[5] * dz);
      if (!(e >= s.log2Cut)) continue; // rejects NaN too
      const float p = math::exp2Normal(e) - s.cut;
      sums.v[2 * j] += p;
      sums.v[2 * j + 1] += p * (value + s.slope[2] * dz);
    }
  }

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    const GridView& grid = bricks.grid;
    const int b = static_cast<int>(block.index()); // Passes::bin() ensures that it fits
    const int bx = b % bricks.nx * BrickReach::kX, by = b / bricks.nx % bricks.ny * BrickReach::kY,
              bz = b / bricks.nx / bricks.ny * BrickReach::kZ;
    const auto warpX = [](int t) { return t / kWarp % 2 * 8; };
    const auto warpY = [](int t) { return t / kWarp / 2 * 4; };
    typename Block::template PerThread<Lanes<float, 2 * kPlanes>> sums;
    typename Block::template PerThread<bool> near;
    typename Block::template PerThread<std::uint32_t> mask[kGroups];
    block.forEachThread([&](int t) { sums[t] = {}; });
    Shared& shared = block.shared();
    const std::int64_t end = start[b + 1];
    for (std::int64_t from = start[b]; from < end; from += kBatch) {
      const int staged = static_cast<int>(math::least<std::int64_t>(kBatch, end - from));
      block.sync();
      block.forEachThread([&](int t) {
        if (t < staged) stage(loaded(gaussians + ids[from + t]), grid, bx, by, bz, t, shared);
      });
      block.sync();
      INNERGS_UNROLL
      for (int group = 0; group < kGroups; ++group) {
        block.forEachThread([&](int t) {
          const int n = group * kWarp + t % kWarp;
          near[t] = n < staged && meets(shared, n, 0, warpX(t), 8) && meets(shared, n, 1, warpY(t), 4);
        });
        block.ballot(near, mask[group]);
      }
      block.forEachThread([&](int t) {
        const float x = static_cast<float>(warpX(t) + t % 8),
                    y = static_cast<float>(warpY(t) + t % kWarp / 8);
        INNERGS_UNROLL
        for (int group = 0; group < kGroups; ++group)
          for (std::uint32_t rest = mask[group][t]; rest; rest &= rest - 1)
            add(shared.staged[group * kWarp + lowestBit(rest)], x, y, sums[t]);
      });
    }
    block.forEachThread([&](int t) {
      const int x = bx + warpX(t) + t % 8, y = by + warpY(t) + t % kWarp / 8;
      INNERGS_UNROLL
      for (int j = 0; j < kPlanes; ++j)
        if (y < grid.ny && bz + j < grid.nz)
          out[(static_cast<std::int64_t>(bz + j) * grid.ny + y) * grid.stride + x] = {sums[t].v[2 * j],
                                                                                      sums[t].v[2 * j + 1]};
    });
  }
};

} // namespace innergs::cuda
