#pragma once
#include <vector>

namespace innergs {

/// Solves A X = B for a symmetric positive definite A [n][n]; B [n][m] becomes X, and A its Cholesky factor.
void solveCholesky(std::vector<double>& a, std::vector<double>& b, int n, int m);

} // namespace innergs
