#pragma once
#include <algorithm>
#include <cmath>

namespace innergs {

/// How coarse a plane must be to be queried in time, judged by how long similar ones took.
class PlaneBudget {
public:
  /// milliseconds: for one plane. fewest: pixels below which their number hardly matters. perPixel:
  /// milliseconds, until something was measured; 0: full resolution until then.
  explicit PlaneBudget(double milliseconds, double fewest = 1, double perPixel = 0)
      : budget_(milliseconds), fewest_(fewest), initial_(perPixel), cost_(perPixel) {}

  /// The size of the pixels to query for a plane of this many, in the plane's own: 1 or more.
  double pixelSize(double pixels) const {
    return cost_ > 0 ? std::max(1.0, std::sqrt(pixels / std::max(budget_ / cost_, fewest_))) : 1;
  }
  void took(double milliseconds, double pixels) { cost_ = milliseconds / pixels; }
  void restart() { cost_ = initial_; }

private:
  double budget_, fewest_, initial_, cost_;
};

} // namespace innergs
