#pragma once
#include "Cuda/Kernels/AlphaTile.h"

namespace innergs::cuda {

/// The gradient of Composite: writes the plane moments of every (Gaussian, tile) pair to the pair's slot.
struct CompositeBackward {
  static constexpr int kThreads = AlphaTile::kThreads, kWarps = kThreads / kWarp, kBatch = kWarp;
  static constexpr int kSums = 8; // math::PlaneMoments: m0, n0, s, x, y, xx, xy, yy
  struct Shared {
    AlphaTile::Staged staged[kBatch];
    float sums[kBatch][kWarps][kSums];
  };
  AlphaTile tile;
  const Pair* f; // ∂L/∂I and I
  math::PlaneMoments<float>* out;

  /// One Gaussian at one point: updates the transmittance `seen` and `rest`, the part of I behind it.
  INNERGS_HD static void add(const AlphaTile::Staged& s, float x, float y, float r, float& seen, float& rest,
                             Lanes<float, kSums>& m) {
    float dx, dy;
    const float q = AlphaTile::amplitude(s, x, y, dx, dy);
    if (!(q > 0)) return;
    const float a = q - s.cut, visible = seen * a;
    rest -= visible * s.value;
    const float f = r * (seen * s.value - rest / (1 - a)), fq = f * q;
    seen -= visible;
    const float part[kSums] = {f * a,   r * visible,  fq,           fq * dx,
                               fq * dy, fq * dx * dx, fq * dx * dy, fq * dy * dy};
    INNERGS_UNROLL
    for (int c = 0; c < kSums; ++c)
      m.v[c] = part[c];
  }

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    static_assert(sizeof(math::PlaneMoments<float>) == kSums * sizeof(float));
    const GridView& grid = tile.tiles.grid;
    const int b = static_cast<int>(block.index()); // Passes::bin() ensures that it fits
    const int left = tile.left(b), top = tile.top(b), plane = tile.plane(b);
    const double z = grid.z[plane];
    typename Block::template PerThread<Pair> state; // transmittance, rest of I
    typename Block::template PerThread<float> r;
    typename Block::template PerThread<bool> near, active;
    typename Block::template PerThread<std::uint32_t> mask;
    typename Block::template PerThread<Lanes<float, kSums>> sums;
    typename Block::template PerThread<float> own;
    constexpr int kEach = kWarp / kSums; // lanes that hold the same sum
    block.forEachThread([&](int t) {
      const int x = left + AlphaTile::pointX(t), y = top + AlphaTile::pointY(t);
      const bool inside = x < grid.nx && y < grid.ny;
      const Pair at =
          inside ? f[(static_cast<std::int64_t>(plane) * grid.ny + y) * grid.stride + x] : Pair{0, 0};
      r[t] = at.a;
      state[t] = {1.f, at.b};
    });
    Shared& shared = block.shared();
    const std::int64_t end = tile.start[b + 1];
    for (std::int64_t from = tile.start[b]; from < end; from += kBatch) {
      const int staged = static_cast<int>(math::least<std::int64_t>(kBatch, end - from));
      block.sync();
      block.forEachThread([&](int t) {
        if (t < staged) tile.stage(from + t, left, top, z, shared.staged[t]);
      });
      block.sync();
      block.forEachThread([&](int t) {
        const int n = t % kWarp;
        near[t] = n < staged && AlphaTile::meets(shared.staged[n], t);
      });
      block.ballot(near, mask);
      for (int n = 0; n < staged; ++n) {
        block.forEachThread([&](int t) {
          sums[t] = {};
          active[t] = mask[t] >> n & 1;
          if (active[t])
            add(shared.staged[n], static_cast<float>(AlphaTile::pointX(t)),
                static_cast<float>(AlphaTile::pointY(t)), r[t], state[t].a, state[t].b, sums[t]);
        });
        block.warpShare(sums, own, active);
        block.forEachThread([&](int t) {
          if (t % kEach == 0) shared.sums[n][t / kWarp][t % kWarp / kEach] = own[t];
        });
      }
      block.sync();
      block.forEachThread([&](int t) {
        const int n = t / kSums, c = t % kSums;
        if (n >= staged) return;
        float sum = 0;
        for (int warp = 0; warp < kWarps; ++warp)
          sum += shared.sums[n][warp][c];
        reinterpret_cast<float*>(out + tile.slots[from + n])[c] = sum;
      });
    }
  }
};

/// Sums the moments of a Gaussian from its slots, in order.
struct SumSlots {
  static constexpr int kThreads = 128;
  using Shared = Nothing;
  const Projected* gaussians;
  std::int64_t count;
  TileReach tiles;
  const std::int64_t* first;
  std::int64_t limit; // maximum of pairs; beyond it, nothing was computed
  const math::PlaneMoments<float>* slots;
  math::Moments<float>* out;
  bool add;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    forEachItem<kThreads>(block, count, [&](std::int64_t i) {
      if (first[count] > limit) return;
      math::Moments<float> sum;
      if (add) sum = out[i];
      std::int64_t slot = first[i];
      tiles.visit(gaussians[i], [&](std::uint64_t, float dz) { math::addPlane(slots[slot++], dz, sum); });
      out[i] = sum;
    });
  }
};

} // namespace innergs::cuda
