#pragma once
#include <cmath>
#include <cstdint>
#include <limits>

namespace innergs {

constexpr double kSameTissue = 0.8;         // least correlation of scans that show the same tissue
constexpr std::int64_t kFewestPoints = 300; // that scans are compared by

/// Sums over the places where two images show the body.
struct PairedSums {
  double n = 0, a = 0, b = 0, aa = 0, bb = 0, ab = 0, squared = 0;

  void add(double x, double y) {
    n += 1;
    a += x;
    b += y;
    aa += x * x;
    bb += y * y;
    ab += x * y;
    squared += (x - y) * (x - y);
  }
  bool enough() const { return n >= static_cast<double>(kFewestPoints); }
  /// Pearson's; NaN: too few places, or one image is constant.
  double correlation() const {
    const double va = aa - a * a / n, vb = bb - b * b / n;
    return enough() && va > 0 && vb > 0 ? (ab - a * b / n) / std::sqrt(va * vb)
                                        : std::numeric_limits<double>::quiet_NaN();
  }
  /// dB; NaN: too few places.
  double psnr(double peak) const {
    return enough() ? -10 * std::log10(squared / n / (peak * peak))
                    : std::numeric_limits<double>::quiet_NaN();
  }
};

} // namespace innergs
