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
  const std::ptrdiff_t stride = grid.stride;
  const V lane = hn::Iota(d, 0.f);
  for (std::size_t n = 0; n < count; ++n) {
    const Projected& g = gaussians[ids[n]];
    const Windows w = windows(g, grid, lanes);
    const V q0 = hn::Set(d, g.quadratic[0]), cut = hn::Set(d, g.cut), slopeY = hn::Set(d, g.slope[1]);
    const RowRecurrence recurrence(d, g);
    ReachedPlanes<selection> planes(g, grid, tile);
    while (planes.list())
      for (const PlaneRows& plane : planes) {
        const float dz = plane.dz, base = g.log2Weight + g.quadratic[5] * dz * dz;
        for (int j = 0; j < w.count; ++j) {
          const int x0 = w.first + j * lanes;
          const V dx = hn::Add(lane, hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
          const V e0 = hn::MulAdd(dx, hn::MulAdd(dx, q0, hn::Set(d, g.quadratic[2] * dz)), hn::Set(d, base));
          const V e1 = hn::MulAdd(dx, hn::Set(d, g.quadratic[1]), hn::Set(d, g.quadratic[4] * dz));
          const V value0 = hn::MulAdd(dx, hn::Set(d, g.slope[0]), hn::Set(d, g.value + g.slope[2] * dz));
          const Columns<selection> columns(d, g, plane.box, dx);
          std::ptrdiff_t at = (static_cast<std::ptrdiff_t>(plane.k) * grid.ny + plane.y0) * stride + x0;
          recurrence(d, plane, dx, e0, e1, [&](V dy, V q) HWY_ATTR {
            const V p = hn::IfThenElseZero(columns(hn::Gt(q, cut)), hn::Sub(q, cut));
            const V value = hn::MulAdd(dy, slopeY, value0);
            // A store to one could delay a load from the other, whose address may end alike.
            const V weight = hn::LoadU(d, weights + at), numerator = hn::LoadU(d, numerators + at);
            hn::StoreU(hn::Add(weight, p), d, weights + at);
            hn::StoreU(hn::MulAdd(p, value, numerator), d, numerators + at);
            at += stride;
          });
        }
      }
  }
}

template <Selection selection>
void gather(const Projected& g, const GridView& grid, const float* f0, const float* f1,
            math::Moments<float>& out) {
  const D d;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const std::ptrdiff_t stride = grid.stride;
  const V lane = hn::Iota(d, 0.f), zero = hn::Zero(d);
  const Windows w = windows(g, grid, lanes);
  const V q0 = hn::Set(d, g.quadratic[0]), cut = hn::Set(d, g.cut), slopeY = hn::Set(d, g.slope[1]);
  const RowRecurrence recurrence(d, g);
  const TileRange everything{0, grid.ny, 0, grid.nz};
  ReachedPlanes<selection> planes(g, grid, everything);
  while (planes.list())
    for (int j = 0; j < w.count; ++j) {
      const int x0 = w.first + j * lanes;
      const V dx = hn::Add(lane, hn::Set(d, static_cast<float>(x0 - g.cell[0]) - g.fraction[0]));
      const V dxq0 = hn::Mul(hn::Mul(dx, dx), q0);
      const V dxq1 = hn::Mul(dx, hn::Set(d, g.quadratic[1]));
      const V dxSlope = hn::MulAdd(dx, hn::Set(d, g.slope[0]), hn::Set(d, g.value));
      // Lanes hold x, so lane sums need only the powers of y and z; those of x follow at the end.
      V m0 = zero, s = zero, sy = zero, sz = zero, syy = zero, syz = zero, szz = zero;
      V n = zero, ny = zero, nz = zero;
      for (const PlaneRows& plane : planes) {
        const float dz = plane.dz;
        const V e0 = hn::MulAdd(dx, hn::Set(d, g.quadratic[2] * dz),
                                hn::Add(dxq0, hn::Set(d, g.log2Weight + g.quadratic[5] * dz * dz)));
        const V e1 = hn::Add(dxq1, hn::Set(d, g.quadratic[4] * dz));
        const V value0 = hn::Add(dxSlope, hn::Set(d, g.slope[2] * dz));
        const Columns<selection> columns(d, g, plane.box, dx);
        V a0 = zero, a1 = zero, a2 = zero, b0 = zero, b1 = zero;
        std::ptrdiff_t at = (static_cast<std::ptrdiff_t>(plane.k) * grid.ny + plane.y0) * stride + x0;
        recurrence(d, plane, dx, e0, e1, [&](V dy, V all) HWY_ATTR {
          const auto inside = columns(hn::Gt(all, cut));
          const V q = hn::IfThenElseZero(inside, all), p = hn::IfThenElseZero(inside, hn::Sub(all, cut));
          const V r = hn::LoadU(d, f0 + at), rp = hn::Mul(r, p);
          const V f = hn::MulAdd(r, hn::MulAdd(dy, slopeY, value0), hn::LoadU(d, f1 + at));
          const V fq = hn::Mul(f, q), fqy = hn::Mul(fq, dy);
          m0 = hn::MulAdd(f, p, m0);
          a0 = hn::Add(a0, fq);
          a1 = hn::Add(a1, fqy);
          a2 = hn::MulAdd(fqy, dy, a2);
          b0 = hn::Add(b0, rp);
          b1 = hn::MulAdd(rp, dy, b1);
          at += stride;
        });
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
      const V sx = hn::Mul(s, dx);
      const V sums[16] = {m0,
                          sx,
                          sy,
                          sz,
                          hn::Mul(sx, dx),
                          hn::Mul(sy, dx),
                          hn::Mul(sz, dx),
                          syy,
                          syz,
                          szz,
                          n,
                          hn::Mul(n, dx),
                          ny,
                          nz,
                          zero,
                          zero};
      float total[16] = {};
      addSums(d, sums, total);
      out.m0 += total[0];
      for (int i = 0; i < 3; ++i)
        out.m1[i] += total[1 + i];
      for (int i = 0; i < 6; ++i)
        out.m2[i] += total[4 + i];
      out.n0 += total[10];
      for (int i = 0; i < 3; ++i)
        out.n1[i] += total[11 + i];
    }
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
