// Vector kernels of the normalised and additive blending. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_FIELD_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_FIELD_INL_H
#undef INNERGS_SIMD_FIELD_INL_H
#else
#define INNERGS_SIMD_FIELD_INL_H
#endif

#include "Core/Render/SimdRows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <Selection selection>
void accumulate(const Projected* gaussians, const std::uint32_t* ids, std::size_t count, const GridView& grid,
                const TileRange& tile, float* weights, float* numerators) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V lane = hn::Iota(d, 0.f);
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    int k0, k1;
    planeRange(g, grid, k0, k1);
    k0 = std::max(k0, tile.k0);
    k1 = std::min(k1, tile.k1);
    const Windows w = windows(g, grid, lanes);
    const V q0 = hn::Set(d, g.quadratic[0]), q3 = hn::Set(d, g.quadratic[3]);
    const V cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut), slopeY = hn::Set(d, g.slope[1]);
    for (int k = k0; k < k1; ++k) {
      const float dz = planeOffset(g, grid.z[k]);
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
        std::size_t at = (static_cast<std::size_t>(k) * grid.ny + y0) * grid.stride + x0;
        for (int y = 0; y < y1 - y0; ++y, at += grid.stride) {
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
void gather(const Projected& g, const GridView& grid, const float* f0, const float* f1,
            math::Moments<float>& out) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const V lane = hn::Iota(d, 0.f), zero = hn::Zero(d);
  int k0, k1;
  planeRange(g, grid, k0, k1);
  const Windows w = windows(g, grid, lanes);
  const V q0 = hn::Set(d, g.quadratic[0]), q3 = hn::Set(d, g.quadratic[3]);
  const V cut = hn::Set(d, g.cut), log2Cut = hn::Set(d, g.log2Cut), slopeY = hn::Set(d, g.slope[1]);
  for (int j = 0; j < w.count; ++j) {
    const int x0 = w.first + j * lanes;
    const V dx = hn::Add(lane, hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
    const V dxq0 = hn::Mul(hn::Mul(dx, dx), q0);
    const V dxq1 = hn::Mul(dx, hn::Set(d, g.quadratic[1]));
    const V dxSlope = hn::MulAdd(dx, hn::Set(d, g.slope[0]), hn::Set(d, g.value));
    // Lanes hold x, so lane sums need only the powers of y and z; those of x follow at the end.
    V m0 = zero, s = zero, sy = zero, sz = zero, syy = zero, syz = zero, szz = zero;
    V n = zero, ny = zero, nz = zero;
    for (int k = k0; k < k1; ++k) {
      const float dz = planeOffset(g, grid.z[k]);
      const PlaneBox box = planeBox<selection>(g, dz);
      int y0, y1;
      if (!tileRows<selection>(g, dz, box, 0, grid.ny, y0, y1)) continue;
      const V e0 = hn::MulAdd(dx, hn::Set(d, g.quadratic[2] * dz),
                              hn::Add(dxq0, hn::Set(d, g.log2Weight + g.quadratic[5] * dz * dz)));
      const V e1 = hn::Add(dxq1, hn::Set(d, g.quadratic[4] * dz));
      const V value0 = hn::Add(dxSlope, hn::Set(d, g.slope[2] * dz));
      const Columns<selection> columns(d, g, box, dx);
      const float dy0 = static_cast<float>(y0 - g.cell[1]) - g.fraction[1];
      V a0 = zero, a1 = zero, a2 = zero, b0 = zero, b1 = zero;
      std::size_t at = (static_cast<std::size_t>(k) * grid.ny + y0) * grid.stride + x0;
      for (int y = 0; y < y1 - y0; ++y, at += grid.stride) {
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

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
