#include "Core/Base/Cholesky.h"

#include <cmath>

namespace innergs {

void solveCholesky(std::vector<double>& a, std::vector<double>& b, int n, int m) {
  for (int j = 0; j < n; ++j) {
    for (int k = 0; k < j; ++k)
      a[j * n + j] -= a[j * n + k] * a[j * n + k];
    a[j * n + j] = std::sqrt(a[j * n + j]);
    for (int i = j + 1; i < n; ++i) {
      for (int k = 0; k < j; ++k)
        a[i * n + j] -= a[i * n + k] * a[j * n + k];
      a[i * n + j] /= a[j * n + j];
    }
  }
  for (int q = 0; q < m; ++q) {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k)
        b[i * m + q] -= a[i * n + k] * b[k * m + q];
      b[i * m + q] /= a[i * n + i];
    }
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k < n; ++k)
        b[i * m + q] -= a[k * n + i] * b[k * m + q];
      b[i * m + q] /= a[i * n + i];
    }
  }
}

} // namespace innergs
