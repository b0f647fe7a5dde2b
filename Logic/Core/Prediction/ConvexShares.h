#pragma once
#include <array>
#include <cstddef>
#include <functional>

namespace innergs {

/// Covariance of the errors of three or four guesses, [row][column].
template <std::size_t N>
using Covariance = std::array<std::array<double, N>, N>;

/// Mean squared error of the guesses mixed with these shares.
template <std::size_t N>
double meanSquare(const Covariance<N>& errors, const std::array<double, N>& share) {
  double sum = 0;
  for (std::size_t a = 0; a < N; ++a)
    for (std::size_t b = 0; b < N; ++b)
      sum += share[a] * share[b] * errors[a][b];
  return sum;
}

/// The shares (non-negative, summing to 1, multiples of 1/20) of least cost; the first guess alone if
/// every cost is NaN.
template <std::size_t N>
std::array<double, N> convexShares(const std::function<double(const std::array<double, N>&)>& cost);
/// Those of least mean squared error.
template <std::size_t N>
std::array<double, N> convexShares(const Covariance<N>& errors);

} // namespace innergs
