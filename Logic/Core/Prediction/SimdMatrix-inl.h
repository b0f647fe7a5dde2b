// Small matrix products in registers. Included once per instruction set (Highway).
#if defined(INNERGS_SIMD_MATRIX_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INNERGS_SIMD_MATRIX_INL_H
#undef INNERGS_SIMD_MATRIX_INL_H
#else
#define INNERGS_SIMD_MATRIX_INL_H
#endif

#include "Core/Prediction/MatrixKernels.h"

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using D = hn::CappedTag<float, 16>;
using V = hn::Vec<D>;

// Rows held in registers at once: their sums, the vectors of B and one vector of A must fit.
#if HWY_TARGET <= HWY_AVX3 && HWY_ARCH_X86
constexpr int kRows = 12;
#elif HWY_ARCH_ARM_A64
constexpr int kRows = 10;
#else
constexpr int kRows = 6;
#endif

/// Computes `rows` rows of C, `vectors` vectors wide.
template <int rows, int vectors>
HWY_NOINLINE void block(const MatrixProduct& p, const float* a, const float* b, float* c) {
  const D d;
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

template <int vectors>
void stripe(const MatrixProduct& p, std::int64_t column) {
  std::int64_t m = 0;
  const auto step = [&]<int rows>() {
    block<rows, vectors>(p, p.a + m * p.rowStep, p.b + column, p.c + m * p.columns + column);
    m += rows;
  };
  // Single rows take as long as four, so the last ones come in blocks of four where that leaves none.
  std::int64_t fours = 0;
  while (fours < 2 && (p.rows - 4 * fours) % kRows != 0)
    ++fours;
  while (m + kRows <= p.rows - 4 * fours)
    step.template operator()<kRows>();
  while (m + 4 <= p.rows)
    step.template operator()<4>();
  while (m < p.rows)
    step.template operator()<1>();
}

void multiply(const MatrixProduct& p) {
  constexpr std::int64_t lanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
  std::int64_t column = 0;
  for (; column + 2 * lanes <= p.columns; column += 2 * lanes)
    stripe<2>(p, column);
  for (; column + lanes <= p.columns; column += lanes)
    stripe<1>(p, column);
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
