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
      sum[r][v] = hn::LoadU(d, c + r * p.columns + v * lanes);
  for (std::int64_t k = 0; k < p.depth; ++k) {
    V right[vectors];
    for (int v = 0; v < vectors; ++v)
      right[v] = hn::LoadU(d, b + v * lanes);
    HWY_UNROLL(12)
    for (int r = 0; r < rows; ++r) {
      const V left = hn::Set(d, a[r * p.rowStep]);
      for (int v = 0; v < vectors; ++v)
        sum[r][v] = hn::MulAdd(left, right[v], sum[r][v]);
    }
    a += p.step;
    b += p.columns;
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
  while (m + kRows <= p.rows)
    step.template operator()<kRows>();
  while (m + 4 <= p.rows)
    step.template operator()<4>();
  while (m < p.rows)
    step.template operator()<1>();
}

void multiplyAdd(const MatrixProduct& p) {
  constexpr std::int64_t lanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
  std::int64_t column = 0;
  for (; column + 2 * lanes <= p.columns; column += 2 * lanes)
    stripe<2>(p, column);
  for (; column + lanes <= p.columns; column += lanes)
    stripe<1>(p, column);
}

void adam(const AdamScalars& s, std::int64_t count, const float* gradient, float* moment1, float* moment2,
          float* parameters) {
  const D d;
  constexpr std::int64_t lanes = static_cast<std::int64_t>(hn::MaxLanes(D()));
  const V beta1 = hn::Set(d, s.beta1), beta2 = hn::Set(d, s.beta2), new1 = hn::Set(d, 1 - s.beta1),
          new2 = hn::Set(d, 1 - s.beta2), scale2 = hn::Set(d, s.scale2), rate = hn::Set(d, s.rate),
          tiny = hn::Set(d, 1e-8f);
  for (std::int64_t i = 0; i + lanes <= count; i += lanes) { // count is a multiple of 16
    const V g = hn::LoadU(d, gradient + i);
    const V m1 = hn::MulAdd(beta1, hn::LoadU(d, moment1 + i), hn::Mul(new1, g));
    const V m2 = hn::MulAdd(beta2, hn::LoadU(d, moment2 + i), hn::Mul(new2, hn::Mul(g, g)));
    hn::StoreU(m1, d, moment1 + i);
    hn::StoreU(m2, d, moment2 + i);
    const V change = hn::Div(hn::Mul(rate, m1), hn::Add(hn::Sqrt(hn::Mul(m2, scale2)), tiny));
    hn::StoreU(hn::Sub(hn::LoadU(d, parameters + i), change), d, parameters + i);
  }
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
