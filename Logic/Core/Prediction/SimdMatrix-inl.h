// Small matrix products in registers. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_MATRIX_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_MATRIX_INL_H
#undef INNERGS_SIMD_MATRIX_INL_H
#else
#define INNERGS_SIMD_MATRIX_INL_H
#endif

#include "Core/Prediction/NetworkKernels.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Rows held in registers at once, two vectors wide: their sums, the vectors of B and one vector of A must
// fit.
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
constexpr int kRows = 12;
#elif HWY_ARCH_ARM_A64
constexpr int kRows = 10;
#else
constexpr int kRows = 6;
#endif
constexpr int kSingleRows = 12; // one vector wide: fewer would wait for their sums

/// Computes `rows` rows of C, `vectors` vectors wide.
template <typename D, int rows, int vectors>
HWY_NOINLINE void block(const MatrixProduct& p, const float* a, const float* b, float* c) {
  const D d;
  using V = hn::Vec<D>;
  constexpr std::int64_t lanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
  V sum[rows][vectors];
  HWY_UNROLL(12)
  for (int r = 0; r < rows; ++r)
    for (int v = 0; v < vectors; ++v)
      sum[r][v] = p.add ? hn::LoadU(d, c + r * p.columns + v * lanes) : hn::Zero(d);
  for (std::int64_t s = 0; s < p.segments; ++s) {
    const float* at = a + s * p.segmentStep;
    for (std::int64_t k = 0; k < p.depth; ++k) {
      V right[vectors];
      for (int v = 0; v < vectors; ++v)
        right[v] = hn::LoadU(d, b + v * lanes);
      HWY_UNROLL(12)
      for (int r = 0; r < rows; ++r) {
        const V left = hn::Set(d, at[r * p.rowStep]);
        for (int v = 0; v < vectors; ++v)
          sum[r][v] = hn::MulAdd(left, right[v], sum[r][v]);
      }
      at += p.step;
      b += p.columns;
    }
  }
  HWY_UNROLL(12)
  for (int r = 0; r < rows; ++r)
    for (int v = 0; v < vectors; ++v)
      hn::StoreU(sum[r][v], d, c + r * p.columns + v * lanes);
}

template <typename D, int vectors>
void stripe(const MatrixProduct& p, std::int64_t column) {
  constexpr int most = vectors == 1 ? kSingleRows : kRows;
  std::int64_t m = 0;
  const auto step = [&]<int rows>() {
    block<D, rows, vectors>(p, p.a + m * p.rowStep, p.b + column, p.c + m * p.columns + column);
    m += rows;
  };
  // Single rows take as long as four, so the last ones come in blocks of four where that leaves none.
  std::int64_t fours = 0;
  while (fours < 2 && (p.rows - 4 * fours) % most != 0)
    ++fours;
  while (m + most <= p.rows - 4 * fours)
    step.template operator()<most>();
  while (m + 4 <= p.rows)
    step.template operator()<4>();
  while (m < p.rows)
    step.template operator()<1>();
}

/// The columns from `first` on that fill vectors of D. Returns the first of the rest.
template <typename D>
std::int64_t stripes(const MatrixProduct& p, std::int64_t first) {
  constexpr std::int64_t lanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
  for (; first + 2 * lanes <= p.columns; first += 2 * lanes)
    stripe<D, 2>(p, first);
  for (; first + lanes <= p.columns; first += lanes)
    stripe<D, 1>(p, first);
  return first;
}

void multiply(const MatrixProduct& p) {
  const std::int64_t rest = stripes<hn::CappedTag<float, 16>>(p, 0);
  if (rest < p.columns) stripes<hn::CappedTag<float, 8>>(p, rest);
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
