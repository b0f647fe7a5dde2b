#include "Core/Candidates.h"
#include "Core/Error.h"
#include "Core/KernelsScalar.h"

// Vectors are members and array elements below, which sizeless types cannot be.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Core/KernelsSimd.cxx"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include <array>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/// 2^e for e ≥ −126 (what lies below is masked by the caller): round, then a degree-5 minimax polynomial on
/// [−½, ½], relative error 2e-7.
HWY_INLINE V exp2(D d, V e) {
  const hn::RebindToSigned<D> di;
  const V magic = hn::Set(d, 12582912.0f); // 1.5·2^23: rounds and leaves the integer in the low bits
  const V shifted = hn::Add(e, magic);
  const V f = hn::Sub(e, hn::Sub(shifted, magic));
  V p = hn::Set(d, 1.33908634e-3f);
  p = hn::MulAdd(p, f, hn::Set(d, 9.67603192e-3f));
  p = hn::MulAdd(p, f, hn::Set(d, 5.55035711e-2f));
  p = hn::MulAdd(p, f, hn::Set(d, 2.40221075e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 6.93147188e-1f));
  p = hn::MulAdd(p, f, hn::Set(d, 1.00000008f));
  return hn::BitCast(d, hn::Add(hn::BitCast(di, p), hn::ShiftLeft<23>(hn::BitCast(di, shifted))));
}

/// 1/x for x in [0.01, 1], relative error about 1e-7.
HWY_INLINE V reciprocal([[maybe_unused]] D d, V x) {
#if HWY_TARGET == HWY_AVX2 || HWY_TARGET == HWY_AVX3 || HWY_TARGET == HWY_AVX3_DL ||                         \
    HWY_TARGET == HWY_AVX3_ZEN4
  const V r = hn::ApproximateReciprocal(x); // 12 bits or more
  return hn::Mul(r, hn::NegMulAdd(x, r, hn::Set(d, 2.f)));
#else
  return hn::Div(hn::Set(d, 1.f), x);
#endif
}

/// Splits the reachable columns into whole windows of `lanes` that stay inside the padded row.
struct Windows {
  int first, count;
};
HWY_INLINE Windows windows(const Projected& g, const LatticeView& lattice, int lanes) {
  int c0, c1;
  columnRange(g, c0, c1);
  const std::int64_t cell = g.cell[0];
  const int x0 = static_cast<int>(std::clamp<std::int64_t>(cell + c0, 0, lattice.nx));
  const int x1 = static_cast<int>(std::clamp<std::int64_t>(cell + c1, 0, lattice.nx));
  const int count = (x1 - x0 + lanes - 1) / lanes;
  return {std::min(x0, lattice.stride - lanes * count), count};
}

template <Selection selection>
HWY_INLINE bool tileRows(const Projected& g, float dz, const PlaneBox& box, int low, int high, int& y0,
                         int& y1) {
  int r0, r1;
  if (!rowRange<selection>(g, dz, box, r0, r1)) return false;
  const std::int64_t cell = g.cell[1];
  y0 = static_cast<int>(std::clamp<std::int64_t>(cell + r0, low, high));
  y1 = static_cast<int>(std::clamp<std::int64_t>(cell + r1, low, high));
  return y0 < y1;
}

/// Lanes of a row that belong to the selection; Exact: all, for those beyond the ellipse have p = 0 anyway.
template <Selection selection>
struct Columns {
  HWY_INLINE Columns(D d, const Projected& g, const PlaneBox& box, V dx) {
    if constexpr (selection != Selection::Exact)
      inside = hn::Le(hn::Abs(hn::Sub(dx, hn::Set(d, box.centre - g.fraction[0]))), hn::Set(d, box.half));
  }
  template <class M>
  HWY_INLINE M operator()(M mask) const {
    if constexpr (selection == Selection::Exact)
      return mask;
    else
      return hn::And(mask, inside);
  }
  hn::Mask<D> inside;
};

template <Selection selection>
void accumulate(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                const LatticeView& lattice, const TileRange& tile, float* weights, float* numerators) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V lane = hn::Iota(d, 0.f);
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    int k0, k1;
    planeRange(g, lattice, k0, k1);
    k0 = std::max(k0, tile.k0);
    k1 = std::min(k1, tile.k1);
    const Windows w = windows(g, lattice, lanes);
    const V q0 = hn::Set(d, g.quadratic[0]), q3 = hn::Set(d, g.quadratic[3]);
    const V cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut), slopeY = hn::Set(d, g.slope[1]);
    for (int k = k0; k < k1; ++k) {
      const float dz = planeOffset(g, lattice.z[k]);
      const PlaneBox box = planeBox<selection>(g, dz);
      int y0, y1;
      if (!tileRows<selection>(g, dz, box, tile.y0, tile.y1, y0, y1)) continue;
      const float base = g.log2Weight + g.quadratic[5] * dz * dz;
      const float dy0 = static_cast<float>(y0 - g.cell[1]) - g.fraction[1];
      for (int j = 0; j < w.count; ++j) {
        const int x0 = w.first + j * lanes;
        const V dx = hn::Add(lane, hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
        const V e0 = hn::MulAdd(dx, hn::MulAdd(dx, q0, hn::Set(d, g.quadratic[2] * dz)), hn::Set(d, base));
        const V e1 = hn::MulAdd(dx, hn::Set(d, g.quadratic[1]), hn::Set(d, g.quadratic[4] * dz));
        const V value0 = hn::MulAdd(dx, hn::Set(d, g.slope[0]), hn::Set(d, g.value + g.slope[2] * dz));
        const Columns<selection> columns(d, g, box, dx);
        std::size_t at = (static_cast<std::size_t>(k) * lattice.ny + y0) * lattice.stride + x0;
        for (int y = 0; y < y1 - y0; ++y, at += lattice.stride) {
          const V dy = hn::Set(d, dy0 + static_cast<float>(y));
          const V e = hn::MulAdd(dy, hn::MulAdd(dy, q3, e1), e0);
          const V p = hn::IfThenElseZero(columns(hn::Ge(e, log2Cut)), hn::Sub(exp2(d, e), cut));
          const V value = hn::MulAdd(dy, slopeY, value0);
          hn::StoreU(hn::Add(hn::LoadU(d, weights + at), p), d, weights + at);
          hn::StoreU(hn::MulAdd(p, value, hn::LoadU(d, numerators + at)), d, numerators + at);
        }
      }
    }
  }
}

template <Selection selection>
void gather(const Projected& g, const LatticeView& lattice, const float* f0, const float* f1,
            math::Moments<float>& out) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V lane = hn::Iota(d, 0.f), zero = hn::Zero(d);
  int k0, k1;
  planeRange(g, lattice, k0, k1);
  const Windows w = windows(g, lattice, lanes);
  const V q0 = hn::Set(d, g.quadratic[0]), q3 = hn::Set(d, g.quadratic[3]);
  const V cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut), slopeY = hn::Set(d, g.slope[1]);
  for (int j = 0; j < w.count; ++j) {
    const int x0 = w.first + j * lanes;
    const V dx = hn::Add(lane, hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
    const V dxq0 = hn::Mul(hn::Mul(dx, dx), q0);
    const V dxq1 = hn::Mul(dx, hn::Set(d, g.quadratic[1]));
    const V dxSlope = hn::MulAdd(dx, hn::Set(d, g.slope[0]), hn::Set(d, g.value));
    // Lanes hold x, so sums per lane need only the powers of y and z; those of x follow at the end.
    V m0 = zero, s = zero, sy = zero, sz = zero, syy = zero, syz = zero, szz = zero;
    V n = zero, ny = zero, nz = zero;
    for (int k = k0; k < k1; ++k) {
      const float dz = planeOffset(g, lattice.z[k]);
      const PlaneBox box = planeBox<selection>(g, dz);
      int y0, y1;
      if (!tileRows<selection>(g, dz, box, 0, lattice.ny, y0, y1)) continue;
      const V e0 = hn::MulAdd(dx, hn::Set(d, g.quadratic[2] * dz),
                              hn::Add(dxq0, hn::Set(d, g.log2Weight + g.quadratic[5] * dz * dz)));
      const V e1 = hn::Add(dxq1, hn::Set(d, g.quadratic[4] * dz));
      const V value0 = hn::Add(dxSlope, hn::Set(d, g.slope[2] * dz));
      const Columns<selection> columns(d, g, box, dx);
      const float dy0 = static_cast<float>(y0 - g.cell[1]) - g.fraction[1];
      V a0 = zero, a1 = zero, a2 = zero, b0 = zero, b1 = zero;
      std::size_t at = (static_cast<std::size_t>(k) * lattice.ny + y0) * lattice.stride + x0;
      for (int y = 0; y < y1 - y0; ++y, at += lattice.stride) {
        const V dy = hn::Set(d, dy0 + static_cast<float>(y));
        const V e = hn::MulAdd(dy, hn::MulAdd(dy, q3, e1), e0);
        const auto inside = columns(hn::Ge(e, log2Cut));
        const V q = hn::IfThenElseZero(inside, exp2(d, e));
        const V p = hn::IfThenElseZero(inside, hn::Sub(q, cut));
        const V r = hn::LoadU(d, f0 + at);
        const V f = hn::MulAdd(r, hn::MulAdd(dy, slopeY, value0), hn::LoadU(d, f1 + at));
        m0 = hn::MulAdd(f, p, m0);
        const V fq = hn::Mul(f, q), fqy = hn::Mul(fq, dy), rp = hn::Mul(r, p);
        a0 = hn::Add(a0, fq);
        a1 = hn::Add(a1, fqy);
        a2 = hn::MulAdd(fqy, dy, a2);
        b0 = hn::Add(b0, rp);
        b1 = hn::MulAdd(rp, dy, b1);
      }
      const V vz = hn::Set(d, dz), a0z = hn::Mul(a0, vz);
      s = hn::Add(s, a0);
      sy = hn::Add(sy, a1);
      sz = hn::Add(sz, a0z);
      syy = hn::Add(syy, a2);
      syz = hn::MulAdd(a1, vz, syz);
      szz = hn::MulAdd(a0z, vz, szz);
      n = hn::Add(n, b0);
      ny = hn::Add(ny, b1);
      nz = hn::MulAdd(b0, vz, nz);
    }
    const auto sum = [&](V v) { return hn::GetLane(hn::SumOfLanes(d, v)); };
    const V sx = hn::Mul(s, dx);
    out.m0 += sum(m0);
    out.m1[0] += sum(sx);
    out.m1[1] += sum(sy);
    out.m1[2] += sum(sz);
    out.m2[0] += sum(hn::Mul(sx, dx));
    out.m2[1] += sum(hn::Mul(sy, dx));
    out.m2[2] += sum(hn::Mul(sz, dx));
    out.m2[3] += sum(syy);
    out.m2[4] += sum(syz);
    out.m2[5] += sum(szz);
    out.n0 += sum(n);
    out.n1[0] += sum(hn::Mul(n, dx));
    out.n1[1] += sum(ny);
    out.n1[2] += sum(nz);
  }
}

/// Depth order jumps through memory.
HWY_INLINE void prefetch(const Projected* gaussians, const std::uint32_t* ids, std::size_t n,
                         std::size_t count) {
  constexpr std::size_t kAhead = 6;
  if (n + kAhead >= count) return;
  const char* next = reinterpret_cast<const char*>(gaussians + ids[n + kAhead]);
  hwy::Prefetch(next);
  hwy::Prefetch(next + 64);
}

/// Sums over the lanes of eight vectors at once, added to out[8].
HWY_INLINE void addSums([[maybe_unused]] D d, const V (&v)[8], float* out) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < 8; ++i)
    out[i] += hn::GetLane(v[i]);
#else
  const hn::Repartition<double, D> pairs;
  const hn::FixedTag<float, 4> quad;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto two = [&](V a, V b) {
    return hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  };
  for (int i = 0; i < 8; i += 4) { // per block of four lanes: the block's sums of four vectors
    const auto low = hn::BitCast(pairs, two(v[i], v[i + 1])),
               high = hn::BitCast(pairs, two(v[i + 2], v[i + 3]));
    HWY_ALIGN float blocks[16];
    hn::Store(hn::Add(hn::BitCast(d, hn::InterleaveLower(pairs, low, high)),
                      hn::BitCast(d, hn::InterleaveUpper(pairs, low, high))),
              d, blocks);
    auto sum = hn::LoadU(quad, out + i);
    for (int block = 0; block < lanes; block += 4)
      sum = hn::Add(sum, hn::Load(quad, blocks + block));
    hn::StoreU(sum, quad, out + i);
  }
#endif
}

/// One Gaussian in the one plane of a tile: its rows, and per window of columns the exponent
/// e0 + dy·(e1 + dy·q3) of row dy.
template <Selection selection>
struct PlanePart {
  HWY_INLINE PlanePart(D d, const Projected& gaussian, const LatticeView& lattice, const TileRange& tile)
      : g(gaussian), lanes(static_cast<int>(hn::Lanes(d))), dz(planeOffset(g, lattice.z[tile.k0])),
        box(planeBox<selection>(g, dz)) {
    if (!tileRows<selection>(g, dz, box, tile.y0, tile.y1, y0, y1)) return;
    windows = HWY_NAMESPACE::windows(g, lattice, lanes);
    dy0 = static_cast<float>(y0 - g.cell[1]) - g.fraction[1];
  }

  struct Window {
    int x0;
    V dx, e0, e1;
    Columns<selection> columns;
  };
  HWY_INLINE Window window(D d, int j) const {
    const int x0 = windows.first + j * lanes;
    const V dx = hn::Add(hn::Iota(d, 0.f), hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
    const V linear = hn::MulAdd(dx, hn::Set(d, g.quadratic[0]), hn::Set(d, g.quadratic[2] * dz));
    return {x0, dx, hn::MulAdd(dx, linear, hn::Set(d, g.log2Weight + g.quadratic[5] * dz * dz)),
            hn::MulAdd(dx, hn::Set(d, g.quadratic[1]), hn::Set(d, g.quadratic[4] * dz)),
            Columns<selection>(d, g, box, dx)};
  }

  const Projected& g;
  int lanes;
  float dz;
  PlaneBox box;
  int y0 = 0, y1 = 0;
  Windows windows{0, 0};
  float dy0 = 0;
};

template <Selection selection>
void composite(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
               const LatticeView& lattice, const TileRange& tile, float* transmittance, float* image) {
  const D d;
  for (std::size_t n = 0; n < count; ++n) {
    prefetch(gaussians, ids, n, count);
    const Projected& g = gaussians[ids[n]];
    const PlanePart<selection> part(d, g, lattice, tile);
    if (part.y0 >= part.y1) continue;
    const V q3 = hn::Set(d, g.quadratic[3]), cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut);
    const V value = hn::Set(d, g.value);
    for (int j = 0; j < part.windows.count; ++j) {
      const auto [x0, dx, e0, e1, columns] = part.window(d, j);
      std::size_t at = (static_cast<std::size_t>(tile.k0) * lattice.ny + part.y0) * lattice.stride + x0;
      for (int y = 0; y < part.y1 - part.y0; ++y, at += lattice.stride) {
        const V dy = hn::Set(d, part.dy0 + static_cast<float>(y));
        const V e = hn::MulAdd(dy, hn::MulAdd(dy, q3, e1), e0);
        const V a = hn::IfThenElseZero(columns(hn::Ge(e, log2Cut)), hn::Sub(exp2(d, e), cut));
        const V seen = hn::LoadU(d, transmittance + at), visible = hn::Mul(seen, a);
        hn::StoreU(hn::MulAdd(visible, value, hn::LoadU(d, image + at)), d, image + at);
        hn::StoreU(hn::Sub(seen, visible), d, transmittance + at);
      }
    }
  }
}

template <Selection selection>
void compositeBackward(const Projected* gaussians, const std::uint32_t* ids, std::size_t count,
                       const LatticeView& lattice, const TileRange& tile, const float* r,
                       float* transmittance, float* rest, math::PlaneMoments<float>* out) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.f);
  for (std::size_t n = 0; n < count; ++n) {
    out[n] = {};
    prefetch(gaussians, ids, n, count);
    const Projected& g = gaussians[ids[n]];
    const PlanePart<selection> part(d, g, lattice, tile);
    if (part.y0 >= part.y1) continue;
    const V q3 = hn::Set(d, g.quadratic[3]), cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut);
    const V value = hn::Set(d, g.value);
    for (int j = 0; j < part.windows.count; ++j) {
      const auto [x0, dx, e0, e1, columns] = part.window(d, j);
      V m0 = zero, n0 = zero, s = zero, sy = zero, syy = zero;
      std::size_t at = (static_cast<std::size_t>(tile.k0) * lattice.ny + part.y0) * lattice.stride + x0;
      std::size_t local = static_cast<std::size_t>(part.y0 - tile.y0) * lattice.stride + x0;
      for (int y = 0; y < part.y1 - part.y0; ++y, at += lattice.stride, local += lattice.stride) {
        const V dy = hn::Set(d, part.dy0 + static_cast<float>(y));
        const V e = hn::MulAdd(dy, hn::MulAdd(dy, q3, e1), e0);
        const auto inside = columns(hn::Ge(e, log2Cut));
        const V q = hn::IfThenElseZero(inside, exp2(d, e));
        const V a = hn::IfThenElseZero(inside, hn::Sub(q, cut));
        const V seen = hn::LoadU(d, transmittance + local), visible = hn::Mul(seen, a);
        const V behind = hn::NegMulAdd(visible, value, hn::LoadU(d, rest + local));
        hn::StoreU(behind, d, rest + local);
        hn::StoreU(hn::Sub(seen, visible), d, transmittance + local);
        const V derivative = hn::LoadU(d, r + at);
        // What lies behind shines through 1 − a of this Gaussian.
        const V f = hn::Mul(derivative,
                            hn::Sub(hn::Mul(seen, value), hn::Mul(behind, reciprocal(d, hn::Sub(one, a)))));
        const V fq = hn::Mul(f, q), fqy = hn::Mul(fq, dy);
        m0 = hn::MulAdd(f, a, m0);
        n0 = hn::MulAdd(derivative, visible, n0);
        s = hn::Add(s, fq);
        sy = hn::Add(sy, fqy);
        syy = hn::MulAdd(fqy, dy, syy);
      }
      const V sx = hn::Mul(s, dx);
      const V sums[8] = {m0, n0, s, sx, sy, hn::Mul(sx, dx), hn::Mul(sy, dx), syy};
      addSums(d, sums, &out[n].m0);
    }
  }
}

KernelSet kernels(Selection selection) {
  const char* name = hwy::TargetName(HWY_TARGET);
  const auto set = [&]<Selection s>() {
    return KernelSet{name, s, accumulate<s>, gather<s>, composite<s>, compositeBackward<s>};
  };
  return selection == Selection::Exact     ? set.template operator()<Selection::Exact>()
         : selection == Selection::Method1 ? set.template operator()<Selection::Method1>()
                                           : set.template operator()<Selection::Method2>();
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace innergs {
HWY_EXPORT(kernels);

namespace {

std::vector<KernelSet> find(Selection selection) {
  std::vector<KernelSet> found;
  for (std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    if (target == HWY_SCALAR || target == HWY_EMU128) continue; // the plain reference is better known
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    found.push_back(HWY_DYNAMIC_DISPATCH(kernels)(selection));
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  found.push_back(scalarKernels(selection));
  return found;
}

} // namespace

const std::vector<KernelSet>& kernelSets(Selection selection) {
  // All at once: finding them switches Highway's global choice of target, which must happen once only.
  static const std::array<std::vector<KernelSet>, 3> sets{find(Selection::Exact), find(Selection::Method1),
                                                          find(Selection::Method2)};
  return sets[static_cast<std::size_t>(selection)];
}

const KernelSet& kernelSet(const std::string& name, Selection selection) {
  const auto& sets = kernelSets(selection);
  if (name.empty()) return sets.front();
  std::string known;
  for (const auto& set : sets) {
    if (set.name == name) return set;
    known += (known.empty() ? "" : ", ") + set.name;
  }
  throw Error(ErrorCode::InvalidArgument, "Instruction set '" + name +
                                              "' is not available on this processor; choose one of " + known +
                                              ".");
}

} // namespace innergs
#endif
