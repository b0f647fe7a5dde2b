#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace innergs {

/// Cubic B-splines with evenly spaced knots over [start, end] (s); outside, the value at the nearer end.
/// With a single coefficient: a constant.
struct TimeSpline {
  double start = 0, end = 1; // s
  int coefficients = 1;      // 1, or at least 4

  /// The four coefficients, starting with `first`, that contribute at a time, and their weights, which sum to
  /// 1.
  struct Weights {
    int first = 0, count = 1;
    std::array<float, 4> weight{1, 0, 0, 0};
  };
  Weights at(double time) const;
  bool operator==(const TimeSpline&) const = default;
};

/// The matrix [coefficient][time] that maps values at `times` to the coefficients of the penalised
/// least-squares spline (P-spline, Eilers & Marx 1996): (BᵀB + smoothing·DᵀD)⁻¹Bᵀ with second differences D.
/// The penalty never vanishes completely, so that coefficients without data are defined.
std::vector<double> splineFit(const TimeSpline& spline, std::span<const double> times, double smoothing);

/// The predictions of that fit at other times, [where][time].
std::vector<double> splinePrediction(const TimeSpline& spline, std::span<const double> times,
                                     std::span<const double> where, double smoothing);

} // namespace innergs
