#pragma once
#include <vector>

namespace innergs {

/// A X = B for a symmetric positive definite A [n][n]; B [n][m] becomes X, A its factor.
void solveCholesky(std::vector<double>& a, std::vector<double>& b, int n, int m);

} // namespace innergs
