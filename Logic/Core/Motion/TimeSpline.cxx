#include "Core/Motion/TimeSpline.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr double kLeastSmoothing = 1e-6;

/// Solves S·X = R for symmetric positive definite S (n×n) and m right-hand sides, in place: R becomes X.
void solve(std::vector<double>& s, std::vector<double>& r, int n, int m) {
  for (int j = 0; j < n; ++j) { // Cholesky, lower triangle
    for (int k = 0; k < j; ++k)
      s[j * n + j] -= s[j * n + k] * s[j * n + k];
    if (!(s[j * n + j] > 0))
      throw Error(ErrorCode::Internal, "A spline in time has no solution; please report this.");
    s[j * n + j] = std::sqrt(s[j * n + j]);
    for (int i = j + 1; i < n; ++i) {
      for (int k = 0; k < j; ++k)
        s[i * n + j] -= s[i * n + k] * s[j * n + k];
      s[i * n + j] /= s[j * n + j];
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < i; ++k)
      for (int c = 0; c < m; ++c)
        r[i * m + c] -= s[i * n + k] * r[k * m + c];
    for (int c = 0; c < m; ++c)
      r[i * m + c] /= s[i * n + i];
  }
  for (int i = n - 1; i >= 0; --i) {
    for (int k = i + 1; k < n; ++k)
      for (int c = 0; c < m; ++c)
        r[i * m + c] -= s[k * n + i] * r[k * m + c];
    for (int c = 0; c < m; ++c)
      r[i * m + c] /= s[i * n + i];
  }
}

} // namespace

TimeSpline::Weights TimeSpline::at(double time) const {
  Weights w;
  if (coefficients < 4) return w;
  const int spans = coefficients - 3;
  const double x = std::clamp((time - start) / (end - start), 0.0, 1.0) * spans;
  w.count = 4;
  w.first = std::min(static_cast<int>(x), spans - 1);
  const double u = x - w.first, v = 1 - u;
  w.weight = {static_cast<float>(v * v * v / 6), static_cast<float>((3 * u * u * u - 6 * u * u + 4) / 6),
              static_cast<float>((3 * v * v * v - 6 * v * v + 4) / 6), static_cast<float>(u * u * u / 6)};
  return w;
}

std::vector<double> splineFit(const TimeSpline& spline, std::span<const double> times, double smoothing) {
  const int n = spline.coefficients, m = static_cast<int>(times.size());
  std::vector<double> s(static_cast<std::size_t>(n) * n, 0.0), r(static_cast<std::size_t>(n) * m, 0.0);
  for (int t = 0; t < m; ++t) {
    const TimeSpline::Weights w = spline.at(times[t]);
    for (int a = 0; a < w.count; ++a) {
      r[static_cast<std::size_t>(w.first + a) * m + t] = static_cast<double>(w.weight[a]);
      for (int b = 0; b < w.count; ++b)
        s[static_cast<std::size_t>(w.first + a) * n + w.first + b] +=
            static_cast<double>(w.weight[a]) * static_cast<double>(w.weight[b]);
    }
  }
  const double penalty = smoothing + kLeastSmoothing;
  constexpr double d[3] = {1, -2, 1};
  for (int i = 0; i + 2 < n; ++i)
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b)
        s[static_cast<std::size_t>(i + a) * n + i + b] += penalty * d[a] * d[b];
  for (int i = 0; i < n; ++i) // two frames determine at most the two coefficients of a straight line
    s[static_cast<std::size_t>(i) * n + i] += 1e-9;
  solve(s, r, n, m);
  return r;
}

std::vector<double> splinePrediction(const TimeSpline& spline, std::span<const double> times,
                                     std::span<const double> where, double smoothing) {
  const std::vector<double> fit = splineFit(spline, times, smoothing);
  std::vector<double> rows(where.size() * times.size(), 0.0);
  for (std::size_t i = 0; i < where.size(); ++i) {
    const TimeSpline::Weights w = spline.at(where[i]);
    for (int a = 0; a < w.count; ++a)
      for (std::size_t t = 0; t < times.size(); ++t)
        rows[i * times.size() + t] +=
            static_cast<double>(w.weight[a]) * fit[(w.first + a) * times.size() + t];
  }
  return rows;
}

} // namespace innergs
