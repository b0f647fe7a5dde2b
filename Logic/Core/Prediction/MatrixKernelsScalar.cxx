#include "Core/Prediction/MatrixKernels.h"

#include <cmath>

namespace innergs {
namespace {

void multiplyAdd(const MatrixProduct& p) {
  for (std::int64_t m = 0; m < p.rows; ++m)
    for (std::int64_t k = 0; k < p.depth; ++k) {
      const float a = p.a[m * p.rowStep + k * p.step];
      for (std::int64_t n = 0; n < p.columns; ++n)
        p.c[m * p.columns + n] += a * p.b[k * p.columns + n];
    }
}

void adam(const AdamScalars& s, std::int64_t count, const float* gradient, float* moment1, float* moment2,
          float* parameters) {
  constexpr float tiny = 1e-8f;
  for (std::int64_t i = 0; i < count; ++i) {
    moment1[i] = s.beta1 * moment1[i] + (1 - s.beta1) * gradient[i];
    moment2[i] = s.beta2 * moment2[i] + (1 - s.beta2) * gradient[i] * gradient[i];
    parameters[i] -= s.rate * moment1[i] / (std::sqrt(moment2[i] * s.scale2) + tiny);
  }
}

} // namespace

MatrixKernels scalarMatrixKernels() {
  return {"scalar", multiplyAdd, adam};
}

} // namespace innergs
