#pragma once
#include "Core/Image/Linear.h"

#include <algorithm>
#include <limits>

namespace innergs {

/// The smallest box along the axes around some points; without any, its low corner lies above the high one.
struct Bounds {
  static constexpr double kFar = std::numeric_limits<double>::max();
  Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};

  void include(const Vec3& x) {
    for (int a = 0; a < 3; ++a) {
      low[a] = std::min(low[a], x[a]);
      high[a] = std::max(high[a], x[a]);
    }
  }
  double longestSide() const { return std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }
};

} // namespace innergs
