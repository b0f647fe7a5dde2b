// Vector kernels of alpha blending. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_ALPHA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_ALPHA_INL_H
#undef INNERGS_SIMD_ALPHA_INL_H
#else
#define INNERGS_SIMD_ALPHA_INL_H
#endif

#include "Core/Render/SimdRows-inl.h"

#include <hwy/cache_control.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Depth order accesses memory at random.
HWY_INLINE void prefetch(const Projected* gaussians, const std::uint32_t* ids, std::size_t n,
                         std::size_t count) {
  constexpr std::size_t kAhead = 6;
  if (n + kAhead >= count) return;
  const char* next = reinterpret_cast<const char*>(gaussians + ids[n + kAhead]);
  hwy::Prefetch(next);
  hwy::Prefetch(next + 64);
}

/// One Gaussian in the single plane of a tile: its rows and, for each window of columns, the exponent e0 +
/// dy·(e1 + dy·q3) of row dy.
template <Selection selection>
struct PlanePart {
  HWY_INLINE PlanePart(D d, const Projected& gaussian, const GridView& grid, const TileRange& tile)
      : g(gaussian), lanes(static_cast<int>(hn::Lanes(d))) {
    if (!rowsOf<selection>(g, grid, tile, tile.k0, rows)) {
      rows.y0 = rows.y1 = 0;
      return;
    }
    windows = HWY_NAMESPACE::windows(g, grid, lanes);
    dy0 = static_cast<float>(rows.y0 - g.cell[1]) - g.fraction[1];
  }

  struct Window {
    int x0;
    V dx, e0, e1;
    Columns<selection> columns;
  };
  HWY_INLINE Window window(D d, int j) const {
    const int x0 = windows.first + j * lanes;
    const V dx = hn::Add(hn::Iota(d, 0.f), hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
    const V linear = hn::MulAdd(dx, hn::Set(d, g.quadratic[0]), hn::Set(d, g.quadratic[2] * rows.dz));
    return {x0, dx, hn::MulAdd(dx, linear, hn::Set(d, g.log2Weight + g.quadratic[5] * rows.dz * rows.dz)),
            hn::MulAdd(dx, hn::Set(d, g.quadratic[1]), hn::Set(d, g.quadratic[4] * rows.dz)),
            Columns<selection>(d, g, rows.box, dx)};
  }

  const Projected& g;
  int lanes;
  PlaneRows rows;
  Windows windows{0, 0};
  float dy0 = 0;
};

template <Selection selection>
void composite(const Projected* gaussians, const std::uint32_t* ids, std::size_t count, const GridView& grid,
               const TileRange& tile, float* transmittance, float* image) {
  const D d;
  for (std::size_t n = 0; n < count; ++n) {
    prefetch(gaussians, ids, n, count);
    const Projected& g = gaussians[ids[n]];
    const PlanePart<selection> part(d, g, grid, tile);
    if (part.rows.y0 >= part.rows.y1) continue;
    const V q3 = hn::Set(d, g.quadratic[3]), cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut);
    const V value = hn::Set(d, g.value);
    for (int j = 0; j < part.windows.count; ++j) {
      const auto [x0, dx, e0, e1, columns] = part.window(d, j);
      std::size_t at = (static_cast<std::size_t>(tile.k0) * grid.ny + part.rows.y0) * grid.stride + x0;
      for (int y = 0; y < part.rows.y1 - part.rows.y0; ++y, at += grid.stride) {
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
                       const GridView& grid, const TileRange& tile, const float* r, float* transmittance,
                       float* rest, math::PlaneMoments<float>* out) {
  const D d;
  const V zero = hn::Zero(d), one = hn::Set(d, 1.f);
  for (std::size_t n = 0; n < count; ++n) {
    out[n] = {};
    prefetch(gaussians, ids, n, count);
    const Projected& g = gaussians[ids[n]];
    const PlanePart<selection> part(d, g, grid, tile);
    if (part.rows.y0 >= part.rows.y1) continue;
    const V q3 = hn::Set(d, g.quadratic[3]), cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut);
    const V value = hn::Set(d, g.value);
    for (int j = 0; j < part.windows.count; ++j) {
      const auto [x0, dx, e0, e1, columns] = part.window(d, j);
      V m0 = zero, n0 = zero, s = zero, sy = zero, syy = zero;
      std::size_t at = (static_cast<std::size_t>(tile.k0) * grid.ny + part.rows.y0) * grid.stride + x0;
      std::size_t local = static_cast<std::size_t>(part.rows.y0 - tile.y0) * grid.stride + x0;
      for (int y = 0; y < part.rows.y1 - part.rows.y0; ++y, at += grid.stride, local += grid.stride) {
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
        // The Gaussians behind this one are seen through its 1 − a.
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

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
