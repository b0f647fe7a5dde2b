// Shared by the vector kernels: exponential, reciprocal, windows of columns. Included once per instruction
// set (Highway).
#if defined(INNERGS_SIMD_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_ROWS_INL_H
#undef INNERGS_SIMD_ROWS_INL_H
#else
#define INNERGS_SIMD_ROWS_INL_H
#endif

#include "Core/Render/Candidates.h"
#include "Core/Render/Rows.h"

#include <algorithm>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

/// 2^e for e ≥ −126 (the caller masks lower values): rounds, then uses a degree-5 minimax polynomial on [−½,
/// ½], relative error 2e-7.
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

/// Splits the reachable columns into full windows of `lanes` that stay inside the padded row.
struct Windows {
  int first, count;
};
HWY_INLINE Windows windows(const Projected& g, const GridView& grid, int lanes) {
  int c0, c1;
  columnRange(g, c0, c1);
  const std::int64_t cell = g.cell[0];
  const int x0 = static_cast<int>(std::clamp<std::int64_t>(cell + c0, 0, grid.nx));
  const int x1 = static_cast<int>(std::clamp<std::int64_t>(cell + c1, 0, grid.nx));
  const int count = (x1 - x0 + lanes - 1) / lanes;
  return {std::min(x0, grid.stride - lanes * count), count};
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

/// Lanes of a row that belong to the selection. Exact: all of them, because p = 0 beyond the ellipse.
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

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
