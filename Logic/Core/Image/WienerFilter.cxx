#include "Core/Image/WienerFilter.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace innergs {
namespace {

constexpr std::int64_t kRadius = 2; // of the window, pixels

/// Sum of the squares of known differences, and their number.
struct Known {
  double squares = 0, count = 0;
};

} // namespace

void wienerFilter(std::span<float> differences, std::int64_t columns, double noise) {
  const std::int64_t rows = static_cast<std::int64_t>(differences.size()) / columns;
  std::vector<Known> columnOf(differences.size()); // of the window's rows
  for (std::int64_t j = 0; j < rows; ++j)
    for (std::int64_t y = std::max<std::int64_t>(0, j - kRadius); y <= std::min(rows - 1, j + kRadius); ++y)
      for (std::int64_t i = 0; i < columns; ++i) {
        const double d = differences[y * columns + i];
        if (!std::isfinite(d)) continue;
        columnOf[j * columns + i].squares += d * d;
        ++columnOf[j * columns + i].count;
      }
  for (std::int64_t j = 0; j < rows; ++j)
    for (std::int64_t i = 0; i < columns; ++i) {
      Known window;
      for (std::int64_t x = std::max<std::int64_t>(0, i - kRadius); x <= std::min(columns - 1, i + kRadius);
           ++x) {
        window.squares += columnOf[j * columns + x].squares;
        window.count += columnOf[j * columns + x].count;
      }
      float& d = differences[j * columns + i];
      if (window.squares > 0 && std::isfinite(d))
        d *= static_cast<float>(std::max(0.0, 1 - noise * noise * window.count / window.squares));
    }
}

} // namespace innergs
