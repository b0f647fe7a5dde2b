// Shared by the vector kernels: exponential, reciprocal, windows of columns, Gaussians down the rows.
// Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_ROWS_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_ROWS_INL_H
#undef INNERGS_SIMD_ROWS_INL_H
#else
#define INNERGS_SIMD_ROWS_INL_H
#endif

#include "Core/Render/Candidates.h"
#include "Core/Render/Rows.h"

#include <algorithm>
#include <bit>
#include <cmath>
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

/// Sums each of `count` vectors (a multiple of four) over its lanes and adds the sums to out[count].
template <int count>
HWY_INLINE void addSums([[maybe_unused]] D d, const V (&v)[count], float* out) {
#if HWY_TARGET == HWY_SCALAR
  for (int i = 0; i < count; ++i)
    out[i] += hn::GetLane(v[i]);
#else
  const hn::Repartition<double, D> pairs;
  const hn::FixedTag<float, 4> quad;
  const int lanes = static_cast<int>(hn::Lanes(d));
  const auto two = [&](V a, V b) {
    return hn::Add(hn::InterleaveLower(d, a, b), hn::InterleaveUpper(d, a, b));
  };
  for (int i = 0; i < count; i += 4) { // for each block of four lanes: the block's sums of four vectors
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

/// Rows [y0, y1) of plane k; `first`: the Gaussian's own first row, at or before y0 where the tile cuts it.
struct PlaneRows {
  float dz;
  PlaneBox box;
  int k, y0, y1;
  std::int64_t first;
};

template <Selection selection>
HWY_INLINE bool rowsOf(const Projected& g, const GridView& grid, const TileRange& tile, int k,
                       PlaneRows& rows) {
  rows.k = k;
  rows.dz = planeOffset(g, grid.z[k]);
  rows.box = planeBox<selection>(g, rows.dz);
  int r0, r1;
  if (!rowRange<selection>(g, rows.dz, rows.box, r0, r1)) return false;
  const std::int64_t cell = g.cell[1];
  rows.first = cell + r0;
  rows.y0 = static_cast<int>(std::clamp<std::int64_t>(rows.first, tile.y0, tile.y1));
  rows.y1 = static_cast<int>(std::clamp<std::int64_t>(cell + r1, tile.y0, tile.y1));
  return rows.y0 < rows.y1;
}

/// The planes of a tile in which a Gaussian reaches any row, some at a time: listed before they are
/// evaluated, so that a processor need not wait for the limits of each.
template <Selection selection>
class ReachedPlanes {
public:
  HWY_INLINE ReachedPlanes(const Projected& g, const GridView& grid, const TileRange& tile)
      : g_(g), grid_(grid), tile_(tile) {
    const double centre = g.cell[2] + static_cast<double>(g.fraction[2]);
    next_ = std::max(firstPlane(grid, centre - g.half[2]), tile.k0);
    last_ = centre + g.half[2];
  }

  /// Lists the next ones; false if there are none.
  HWY_INLINE bool list() {
    count_ = 0;
    for (; next_ < tile_.k1 && grid_.z[next_] <= last_ && count_ < kMost; ++next_)
      count_ += rowsOf<selection>(g_, grid_, tile_, next_, planes_[count_]);
    return count_ > 0;
  }
  const PlaneRows* begin() const { return planes_; }
  const PlaneRows* end() const { return planes_ + count_; }

private:
  static constexpr int kMost = 16;
  const Projected& g_;
  const GridView& grid_;
  const TileRange& tile_;
  int next_, count_ = 0;
  double last_; // in reach, index units
  PlaneRows planes_[kMost];
};

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

/// 2^x for −126 ≤ x ≤ 0 to the precision of float, without a call that would spill the vectors.
HWY_INLINE float exp2Precise(float x) {
  const int whole = static_cast<int>(x - 0.5f);
  const double f = (static_cast<double>(x) - whole) * 0.69314718055994530942;
  const double p =
      1 + f * (1 + f * (0.5 + f * (1 / 6.0 + f * (1 / 24.0 + f * (1 / 120.0 + f * (1 / 720.0 + f / 5040))))));
  return static_cast<float>(p) * std::bit_cast<float>((whole + 127) << 23);
}

/// w·p of a Gaussian, row after row: from row to row it changes by a factor that itself changes by a constant
/// one, so that only the first of kRun rows takes exponentials (relative error of the others at most 1e-5).
/// Runs are counted from the Gaussian's own first row, so that values do not depend on how a grid is divided.
class RowRecurrence {
public:
  HWY_INLINE RowRecurrence(D d, const Projected& g) : g_(g), q3_(hn::Set(d, g.quadratic[3])) {
    const float* q = g.quadratic;
    const float x = g.half[0] + 1, y = g.half[1] + 1, z = g.half[2];
    const float drop = -(q[0] * x * x + q[3] * y * y + q[5] * z * z) + std::fabs(q[1]) * x * y +
                       std::fabs(q[2]) * x * z + std::fabs(q[4]) * y * z;
    // On the way, values and factors of steep Gaussians could leave the range of float.
    if (!(drop < 100 && g.log2Weight - drop > -110)) return;
    recurs_ = true;
    reach_ = x;
    step_ = exp2Precise(std::max(2 * q[3], -126.f));
  }

  /// Calls row(dy, w·p) for the rows of a plane, where the exponent is e0 + dy·(e1 + dy·quadratic[3]) in
  /// columns that lie dx from the mean. w·p may be 0 wherever it is below the cut.
  template <class Row>
  HWY_INLINE void operator()(D d, const PlaneRows& rows, V dx, V e0, V e1, Row&& row) const {
    const auto offset = [&](int y) { return static_cast<float>(y - g_.cell[1]) - g_.fraction[1]; };
    if (!recurs_) {
      for (int y = rows.y0; y < rows.y1; ++y) {
        const V dy = hn::Set(d, offset(y));
        const V e = hn::MulAdd(dy, hn::MulAdd(dy, q3_, e1), e0);
        row(dy, hn::IfThenElseZero(hn::Ge(e, hn::Set(d, g_.log2Cut)), exp2(d, e)));
      }
      return;
    }
    const auto reached = hn::Le(hn::Abs(dx), hn::Set(d, reach_));
    const V step = hn::Set(d, step_), one = hn::Set(d, 1.f);
    for (int y = rows.y0 - static_cast<int>(static_cast<std::uint64_t>(rows.y0 - rows.first) % kRun);
         y < rows.y1;) {
      const float first = offset(y);
      V dy = hn::Set(d, first);
      V p = hn::IfThenElseZero(reached, exp2(d, hn::MulAdd(dy, hn::MulAdd(dy, q3_, e1), e0)));
      V factor = hn::IfThenElseZero(reached, exp2(d, hn::MulAdd(hn::Set(d, 2 * first + 1), q3_, e1)));
      const auto next = [&]() HWY_ATTR {
        p = hn::Mul(p, factor);
        factor = hn::Mul(factor, step);
        dy = hn::Add(dy, one);
        ++y;
      };
      const int end = std::min(y + static_cast<int>(kRun), rows.y1);
      while (y < rows.y0)
        next();
      while (y < end) {
        row(dy, p);
        next();
      }
    }
  }

private:
  static constexpr unsigned kRun = 16;
  const Projected& g_;
  V q3_;
  bool recurs_ = false;
  float step_ = 0, reach_ = 0; // the constant factor; from the mean, columns
};

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
