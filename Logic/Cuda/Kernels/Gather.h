#pragma once
#include "Core/Render/Rows.h"
#include "Cuda/Block.h"

namespace innergs::cuda {

/// The moments of one Gaussian over the rows of its exact ellipsoid: the part that one lane adds up. As many
/// lanes as the Gaussian is wide lie side by side in x, the others take the next rows; warps take planes in
/// turn.
struct GatherRows {
  static constexpr int kSums = 14, kLanes = 16; // math::Moments: m0, m1, m2, n0, n1; and two zeros
  using Sums = Lanes<float, kLanes>;
  GridView grid;
  const Pair* f;

  /// The part of one row, before dy and dz are applied.
  struct Row {
    float a = 0, n = 0, nx = 0, s = 0, sx = 0, sxx = 0;
  };

  INNERGS_HD Row row(const Projected& g, float dy, float dz, const Pair* line, int lane, int lanes) const {
    Row sum;
    float centre, half;
    ellipsoidRow(g, dy, dz, centre, half);
    const int x0 = column(g, indexFrom(centre - half)), x1 = column(g, indexUpTo(centre + half) + 1);
    const float* q = g.quadratic;
    const float e0 = q[3] * dy * dy + q[4] * dy * dz + q[5] * dz * dz + g.log2Weight;
    const float e1 = q[1] * dy + q[2] * dz, value = g.value + g.slope[1] * dy + g.slope[2] * dz;
    for (int x = x0 + lane; x < x1; x += lanes) {
      const float dx = static_cast<float>(x - g.cell[0]) - g.fraction[0];
      const float e = e0 + dx * (e1 + q[0] * dx);
      if (!(e >= g.log2Cut)) continue; // rejects NaN too
      const Pair at = line[x];
      const float p = math::exp2Normal(e), cut = p - g.cut;
      const float whole = at.a * (value + g.slope[0] * dx) + at.b;
      const float fp = whole * p, n = at.a * cut;
      sum.a += whole * cut;
      sum.n += n;
      sum.nx += n * dx;
      sum.s += fp;
      sum.sx += fp * dx;
      sum.sxx += fp * dx * dx;
    }
    return sum;
  }

  INNERGS_HD int column(const Projected& g, int x) const {
    return math::clamped(g.cell[0] + x, 0, grid.nx); // within ±1.1e9: indexFrom(), projectGaussian()
  }

  INNERGS_HD static void addRow(const Row& r, float dy, float dz, Sums& m) {
    const float part[kSums] = {r.a,       r.sx,      r.s * dy,      r.s * dz,      r.sxx,
                               r.sx * dy, r.sx * dz, r.s * dy * dy, r.s * dy * dz, r.s * dz * dz,
                               r.n,       r.nx,      r.n * dy,      r.n * dz};
    INNERGS_UNROLL
    for (int c = 0; c < kSums; ++c)
      m.v[c] += part[c];
  }

  /// Lanes side by side: a row costs as much as five points of a lane, so few of them but many rows.
  INNERGS_HD static int laneBits(const Projected& g) {
    int bits = 2;
    while (bits < 5 && static_cast<float>(4 << bits) < 2 * g.half[0])
      ++bits;
    return bits;
  }

  INNERGS_HD void visit(const Projected& g, int lane, int warp, int warps, Sums& m) const {
    const int bits = laneBits(g), lanes = 1 << bits, step = kWarp >> bits, across = lane & (lanes - 1);
    int k0, k1;
    planeRange(g, grid, k0, k1);
    for (int k = k0 + warp; k < k1; k += warps) {
      const float dz = planeOffset(g, grid.z[k]);
      int r0, r1;
      if (!rowRange(g, dz, r0, r1)) continue;
      const int y0 = math::clamped(g.cell[1] + r0, 0, grid.ny),
                y1 = math::clamped(g.cell[1] + r1, 0, grid.ny);
      for (int y = y0 + (lane >> bits); y < y1; y += step) {
        const float dy = static_cast<float>(y - g.cell[1]) - g.fraction[1];
        const Pair* line = f + (static_cast<std::int64_t>(k) * grid.ny + y) * grid.stride;
        addRow(row(g, dy, dz, line, across, lanes), dy, dz, m);
      }
    }
  }

  /// Whether a block should share the work: the box has too many points for one warp.
  INNERGS_HD static bool large(const Projected& g) { return 8 * g.half[0] * g.half[1] * g.half[2] > 65536; }

  /// Writes sum number c.
  INNERGS_HD static void write(float sum, int c, bool add, math::Moments<float>& out) {
    static_assert(sizeof(math::Moments<float>) == kSums * sizeof(float));
    if (c >= kSums) return;
    float* moment = reinterpret_cast<float*>(&out) + c;
    *moment = add ? *moment + sum : sum;
  }
};

/// One warp per Gaussian; no atomics.
struct Gather {
  static constexpr int kThreads = 128, kWarps = kThreads / kWarp;
  using Shared = Nothing;
  const Projected* gaussians;
  std::int64_t count;
  GatherRows rows;
  math::Moments<float>* out;
  bool add; // to the content of `out`

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    constexpr int kEach = kWarp / GatherRows::kLanes; // lanes that hold the same sum
    typename Block::template PerThread<GatherRows::Sums> sums;
    typename Block::template PerThread<float> own;
    typename Block::template PerThread<bool> active;
    block.forEachThread([&](int t) {
      const std::int64_t i = block.index() * kWarps + t / kWarp;
      sums[t] = {};
      active[t] = false;
      if (i >= count) return;
      const Projected g = loaded(gaussians + i);
      active[t] = !GatherRows::large(g);
      if (active[t]) rows.visit(g, t % kWarp, 0, 1, sums[t]);
    });
    block.warpShare(sums, own);
    block.forEachThread([&](int t) {
      if (active[t] && t % kEach == 0)
        GatherRows::write(own[t], t % kWarp / kEach, add, out[block.index() * kWarps + t / kWarp]);
    });
  }
};

/// The large Gaussians: a block scans kWarp Gaussians and processes the large ones one after another.
struct GatherLarge {
  static constexpr int kThreads = 256, kWarps = kThreads / kWarp;
  struct Shared {
    float warps[kWarps][GatherRows::kLanes];
  };
  const Projected* gaussians;
  std::int64_t count;
  GatherRows rows;
  math::Moments<float>* out;
  bool add;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    constexpr int kEach = kWarp / GatherRows::kLanes;
    typename Block::template PerThread<GatherRows::Sums> sums;
    typename Block::template PerThread<float> own;
    typename Block::template PerThread<bool> large;
    typename Block::template PerThread<std::uint32_t> mask; // every warp's, for the same Gaussians
    Shared& shared = block.shared();
    const std::int64_t first = block.index() * kWarp;
    block.forEachThread([&](int t) {
      const std::int64_t i = first + t % kWarp;
      large[t] = i < count && GatherRows::large(gaussians[i]);
    });
    block.ballot(large, mask);
    for (std::uint32_t rest = mask[0]; rest; rest &= rest - 1) { // identical for the whole block
      const std::int64_t i = first + lowestBit(rest);
      block.forEachThread([&](int t) {
        sums[t] = {};
        rows.visit(loaded(gaussians + i), t % kWarp, t / kWarp, kWarps, sums[t]);
      });
      block.warpShare(sums, own);
      block.sync();
      block.forEachThread([&](int t) {
        if (t % kEach == 0) shared.warps[t / kWarp][t % kWarp / kEach] = own[t];
      });
      block.sync();
      block.forEachThread([&](int t) {
        if (t >= GatherRows::kLanes) return;
        float total = 0;
        for (int w = 0; w < kWarps; ++w)
          total += shared.warps[w][t];
        GatherRows::write(total, t, add, out[i]);
      });
    }
  }
};

} // namespace innergs::cuda
