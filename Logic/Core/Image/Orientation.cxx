#include "Core/Image/Orientation.h"

#include <algorithm>
#include <cmath>

namespace innergs {

std::array<int, 3> nearestAxes(const Mat3& direction) {
  std::array<int, 3> order{0, 1, 2}, best = order;
  double largest = -1;
  do {
    double sum = 0;
    for (int a = 0; a < 3; ++a)
      sum += std::abs(direction[order[a]][a]);
    if (sum > largest + 1e-9) { // the first of equal sums, whatever the rounding
      largest = sum;
      best = order;
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

std::string orientationCode(const Mat3& direction) {
  const std::array<int, 3> axes = nearestAxes(direction);
  std::string code;
  for (int a = 0; a < 3; ++a)
    code += direction[axes[a]][a] >= 0 ? "LPS"[axes[a]] : "RAI"[axes[a]];
  return code;
}

} // namespace innergs
