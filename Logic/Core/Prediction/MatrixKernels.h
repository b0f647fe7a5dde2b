#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace innergs {

/// C += A·B in single precision, for matrices inside larger arrays: A(m, k) = a[m·rowStep + k·step], B(k, n)
/// = b[k·columns + n], C(m, n) = c[m·columns + n]. With overlapping rows, A makes it a convolution.
struct MatrixProduct {
  std::int64_t rows = 0, depth = 0; // of A
  std::int64_t columns = 0;         // of B and C: a multiple of 16
  const float* a = nullptr;
  std::int64_t rowStep = 0, step = 1;
  const float* b = nullptr;
  float* c = nullptr;
};

/// The constants of one Adam step; `count` parameters, a multiple of 16.
struct AdamScalars {
  float rate;         // divided by the first moment's bias correction
  float beta1, beta2; // decay rates of the moments
  float scale2;       // 1 / the second moment's bias correction
};

/// The inner loops of training, for one instruction set. Sums run over `depth` in ascending order.
struct MatrixKernels {
  std::string name;
  void (*multiplyAdd)(const MatrixProduct& product);
  void (*adam)(const AdamScalars& step, std::int64_t count, const float* gradient, float* moment1,
               float* moment2, float* parameters);
};

/// Best first. The last is "scalar", the plain reference that all others are tested against.
const std::vector<MatrixKernels>& matrixKernelSets();
/// Empty name: the best. Throws Error(InvalidArgument) for a name that this processor does not support.
const MatrixKernels& matrixKernels(const std::string& name);

/// The plain reference.
MatrixKernels scalarMatrixKernels();

} // namespace innergs
