#pragma once
#include "Cuda/Block.h"
#include "Cuda/Kernels/Reach.h"

namespace innergs::cuda {

/// W = Σ w p and N = Σ w p (c + g·d) of one brick a block: every thread owns a column of four points, each
/// warp 8×4 columns and looks only at the staged Gaussians whose box meets them.
struct Accumulate {
  static constexpr int kThreads = 128, kBatch = 64, kGroups = kBatch / kWarp;
  static constexpr int kPlanes = BrickReach::kZ;
  struct Staged {
    std::int32_t cell[2];
    float fraction[2], quadratic[6], log2Weight, log2Cut, cut, value, slope[3], half[2];
    float dz[kPlanes];
  };
  struct Shared {
    Staged staged[kBatch];
  };
  const Projected* gaussians;
  BrickReach bricks;
  const std::int64_t* start;
  const std::uint32_t* ids;
  Pair* out;

  INNERGS_HD static void stage(const Projected& g, const LatticeView& lattice, int k0, Staged& s) {
    for (int a = 0; a < 2; ++a) {
      s.cell[a] = g.cell[a];
      s.fraction[a] = g.fraction[a];
      s.half[a] = g.half[a];
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
      s.dz[j] = planeOffset(g, lattice.z[k0 + j < lattice.nz ? k0 + j : lattice.nz - 1]);
  }

  INNERGS_HD static bool meets(const Staged& s, int axis, int low, int width) {
    const float at = static_cast<float>(s.cell[axis] - low) + s.fraction[axis];
    return at + s.half[axis] >= 0 && at - s.half[axis] <= static_cast<float>(width - 1);
  }

  INNERGS_HD static void add(const Staged& s, int x, int y, Lanes<float, 2 * kPlanes>& sums) {
    const float dx = static_cast<float>(x - s.cell[0]) - s.fraction[0];
    const float dy = static_cast<float>(y - s.cell[1]) - s.fraction[1];
    const float* q = s.quadratic;
    const float e0 = q[0] * dx * dx + q[1] * dx * dy + q[3] * dy * dy + s.log2Weight;
    const float e1 = q[2] * dx + q[4] * dy, value = s.value + s.slope[0] * dx + s.slope[1] * dy;
    INNERGS_UNROLL
    for (int j = 0; j < kPlanes; ++j) {
      const float dz = s.dz[j], e = e0 + dz * (e1 + q[5] * dz);
      if (!(e >= s.log2Cut)) continue; // NaN as well
      const float p = std::exp2(e) - s.cut;
      sums.v[2 * j] += p;
      sums.v[2 * j + 1] += p * (value + s.slope[2] * dz);
    }
  }

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    const LatticeView& lattice = bricks.lattice;
    const std::int64_t b = block.index();
    const int bx = static_cast<int>(b % bricks.nx) * BrickReach::kX,
              by = static_cast<int>(b / bricks.nx % bricks.ny) * BrickReach::kY,
              bz = static_cast<int>(b / bricks.nx / bricks.ny) * BrickReach::kZ;
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
        if (t < staged) stage(gaussians[ids[from + t]], lattice, bz, shared.staged[t]);
      });
      block.sync();
      INNERGS_UNROLL
      for (int group = 0; group < kGroups; ++group) {
        block.forEachThread([&](int t) {
          const int n = group * kWarp + t % kWarp, wx = bx + t / kWarp % 2 * 8, wy = by + t / kWarp / 2 * 4;
          near[t] = n < staged && meets(shared.staged[n], 0, wx, 8) && meets(shared.staged[n], 1, wy, 4);
        });
        block.ballot(near, mask[group]);
      }
      block.forEachThread([&](int t) {
        const int x = bx + t / kWarp % 2 * 8 + t % 8, y = by + t / kWarp / 2 * 4 + t % kWarp / 8;
        INNERGS_UNROLL
        for (int group = 0; group < kGroups; ++group)
          for (std::uint32_t rest = mask[group][t]; rest; rest &= rest - 1)
            add(shared.staged[group * kWarp + lowestBit(rest)], x, y, sums[t]);
      });
    }
    block.forEachThread([&](int t) {
      const int x = bx + t / kWarp % 2 * 8 + t % 8, y = by + t / kWarp / 2 * 4 + t % kWarp / 8;
      INNERGS_UNROLL
      for (int j = 0; j < kPlanes; ++j)
        if (y < lattice.ny && bz + j < lattice.nz)
          out[(static_cast<std::int64_t>(bz + j) * lattice.ny + y) * lattice.stride + x] = {
              sums[t].v[2 * j], sums[t].v[2 * j + 1]};
    });
  }
};

} // namespace innergs::cuda
