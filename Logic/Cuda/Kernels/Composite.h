#pragma once
#include "Cuda/Kernels/AlphaTile.h"

namespace innergs::cuda {

/// Alpha-blends front to back: the transmittance behind all Gaussians, and I.
struct Composite {
  static constexpr int kThreads = AlphaTile::kThreads, kBatch = 128, kGroups = kBatch / kWarp;
  struct Shared {
    AlphaTile::Staged staged[kBatch];
  };
  AlphaTile tile;
  Pair* out;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    const GridView& grid = tile.tiles.grid;
    const int b = static_cast<int>(block.index()); // Passes::bin() ensures that it fits
    const int left = tile.left(b), top = tile.top(b), plane = tile.plane(b);
    const double z = grid.z[plane];
    typename Block::template PerThread<Pair> state;
    typename Block::template PerThread<bool> near;
    typename Block::template PerThread<std::uint32_t> mask[kGroups];
    block.forEachThread([&](int t) { state[t] = {1.f, 0.f}; });
    Shared& shared = block.shared();
    const std::int64_t end = tile.start[b + 1];
    for (std::int64_t from = tile.start[b]; from < end; from += kBatch) {
      const int staged = static_cast<int>(math::least<std::int64_t>(kBatch, end - from));
      block.sync();
      block.forEachThread([&](int t) {
        if (t < staged) tile.stage(from + t, left, top, z, shared.staged[t]);
      });
      block.sync();
      INNERGS_UNROLL
      for (int group = 0; group < kGroups; ++group) {
        block.forEachThread([&](int t) {
          const int n = group * kWarp + t % kWarp;
          near[t] = n < staged && AlphaTile::meets(shared.staged[n], t);
        });
        block.ballot(near, mask[group]);
      }
      block.forEachThread([&](int t) {
        const float x = static_cast<float>(AlphaTile::pointX(t)),
                    y = static_cast<float>(AlphaTile::pointY(t));
        Pair own = state[t];
        INNERGS_UNROLL
        for (int group = 0; group < kGroups; ++group)
          for (std::uint32_t rest = mask[group][t]; rest; rest &= rest - 1) {
            const AlphaTile::Staged& s = shared.staged[group * kWarp + lowestBit(rest)];
            float dx, dy;
            const float q = AlphaTile::amplitude(s, x, y, dx, dy);
            if (!(q > 0)) continue;
            const float visible = own.a * (q - s.cut);
            own.b += visible * s.value;
            own.a -= visible;
          }
        state[t] = own;
      });
    }
    block.forEachThread([&](int t) {
      const int x = left + AlphaTile::pointX(t), y = top + AlphaTile::pointY(t);
      if (y < grid.ny) out[(static_cast<std::int64_t>(plane) * grid.ny + y) * grid.stride + x] = state[t];
    });
  }
};

} // namespace innergs::cuda
