#pragma once
#include "Core/Rows.h"
#include "Cuda/Block.h"

namespace innergs::cuda {

/// The moments of one Gaussian over the rows of its exact ellipsoid: what one lane of some warps adds up.
/// Lanes lie side by side in x, as many as the Gaussian is wide, and the others take the next rows; warps
/// take the planes in turn.
struct GatherRows {
  static constexpr int kSums = 14; // math::Moments: m0, m1, m2, n0, n1
  using Sums = Lanes<float, kSums>;
  LatticeView lattice;
  const Pair* f;

  /// One row's part, with dy and dz left out.
  struct Row {
    float a = 0, n = 0, nx = 0, s = 0, sx = 0, sxx = 0;
  };

  INNERGS_HD Row row(const Projected& g, float dy, float dz, const Pair* line, int lane, int lanes) const {
    Row sum;
    float centre, half;
    ellipsoidRow(g, dy, dz, centre, half);
    const int x0 = column(g, indexLimit(std::ceil(centre - half))),
              x1 = column(g, indexLimit(std::floor(centre + half)) + 1);
    const float* q = g.quadratic;
    const float e0 = q[3] * dy * dy + q[4] * dy * dz + q[5] * dz * dz + g.log2Weight;
    const float e1 = q[1] * dy + q[2] * dz, value = g.value + g.slope[1] * dy + g.slope[2] * dz;
    for (int x = x0 + lane; x < x1; x += lanes) {
      const float dx = static_cast<float>(x - g.cell[0]) - g.fraction[0];
      const float e = e0 + dx * (e1 + q[0] * dx);
      if (!(e >= g.log2Cut)) continue; // NaN as well
      const Pair at = line[x];
      const float p = std::exp2(e), cut = p - g.cut;
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
    return static_cast<int>(
        math::clamped<std::int64_t>(static_cast<std::int64_t>(g.cell[0]) + x, 0, lattice.nx));
  }

  INNERGS_HD static void addRow(const Row& r, float dy, float dz, Sums& m) {
    const float part[kSums] = {r.a,       r.sx,      r.s * dy,      r.s * dz,      r.sxx,
                               r.sx * dy, r.sx * dz, r.s * dy * dy, r.s * dy * dz, r.s * dz * dz,
                               r.n,       r.nx,      r.n * dy,      r.n * dz};
    INNERGS_UNROLL
    for (int c = 0; c < kSums; ++c)
      m.v[c] += part[c];
  }

  INNERGS_HD void visit(const Projected& g, int lane, int warp, int warps, Sums& m) const {
    int lanes = 4;
    while (lanes < kWarp && static_cast<float>(lanes) < 2 * g.half[0])
      lanes *= 2;
    const int step = kWarp / lanes;
    int k0, k1;
    planeRange(g, lattice, k0, k1);
    for (int k = k0 + warp; k < k1; k += warps) {
      const float dz = planeOffset(g, lattice.z[k]);
      int r0, r1;
      if (!rowRange(g, dz, r0, r1)) continue;
      const std::int64_t cell = g.cell[1];
      const int y0 = static_cast<int>(math::clamped<std::int64_t>(cell + r0, 0, lattice.ny)),
                y1 = static_cast<int>(math::clamped<std::int64_t>(cell + r1, 0, lattice.ny));
      for (int y = y0 + lane / lanes; y < y1; y += step) {
        const float dy = static_cast<float>(y - g.cell[1]) - g.fraction[1];
        const Pair* line = f + (static_cast<std::int64_t>(k) * lattice.ny + y) * lattice.stride;
        addRow(row(g, dy, dz, line, lane % lanes, lanes), dy, dz, m);
      }
    }
  }

  /// Whether a block should share the work: its box has more points than a warp can do in good time.
  INNERGS_HD static bool large(const Projected& g) { return 8 * g.half[0] * g.half[1] * g.half[2] > 65536; }

  /// Lane c writes the c-th sum.
  INNERGS_HD static void write(const Sums& sums, int lane, bool add, math::Moments<float>& out) {
    static_assert(sizeof(math::Moments<float>) == kSums * sizeof(float));
    float* moments = reinterpret_cast<float*>(&out);
    INNERGS_UNROLL
    for (int c = 0; c < kSums; ++c)
      if (lane == c) moments[c] = add ? moments[c] + sums.v[c] : sums.v[c];
  }
};

/// A warp a Gaussian; no atomics.
struct Gather {
  static constexpr int kThreads = 128, kWarps = kThreads / kWarp;
  using Shared = Nothing;
  const Projected* gaussians;
  std::int64_t count;
  GatherRows rows;
  math::Moments<float>* out;
  bool add; // to what `out` holds

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<GatherRows::Sums> sums;
    block.forEachThread([&](int t) {
      const std::int64_t i = block.index() * kWarps + t / kWarp;
      sums[t] = {};
      if (i < count && !GatherRows::large(gaussians[i])) rows.visit(gaussians[i], t % kWarp, 0, 1, sums[t]);
    });
    block.warpSum(sums);
    block.forEachThread([&](int t) {
      const std::int64_t i = block.index() * kWarps + t / kWarp;
      if (i < count && !GatherRows::large(gaussians[i])) GatherRows::write(sums[t], t % kWarp, add, out[i]);
    });
  }
};

/// The large ones: a block looks through kWarp Gaussians and does those one after the other.
struct GatherLarge {
  static constexpr int kThreads = 256, kWarps = kThreads / kWarp;
  struct Shared {
    GatherRows::Sums warps[kWarps];
  };
  const Projected* gaussians;
  std::int64_t count;
  GatherRows rows;
  math::Moments<float>* out;
  bool add;

  template <class Block>
  INNERGS_KERNEL void operator()(Block& block) const {
    typename Block::template PerThread<GatherRows::Sums> sums;
    Shared& shared = block.shared();
    const std::int64_t first = block.index() * kWarp, last = math::least<std::int64_t>(count, first + kWarp);
    for (std::int64_t i = first; i < last; ++i) {
      if (!GatherRows::large(gaussians[i])) continue; // the same for the whole block
      block.forEachThread([&](int t) {
        sums[t] = {};
        rows.visit(gaussians[i], t % kWarp, t / kWarp, kWarps, sums[t]);
      });
      block.warpSum(sums);
      block.sync();
      block.forEachThread([&](int t) {
        if (t % kWarp == 0) shared.warps[t / kWarp] = sums[t];
      });
      block.sync();
      block.forEachThread([&](int t) {
        if (t >= kWarp) return;
        GatherRows::Sums total = {};
        for (int w = 0; w < kWarps; ++w) {
          INNERGS_UNROLL
          for (int c = 0; c < GatherRows::kSums; ++c)
            total.v[c] += shared.warps[w].v[c];
        }
        GatherRows::write(total, t, add, out[i]);
      });
    }
  }
};

} // namespace innergs::cuda
