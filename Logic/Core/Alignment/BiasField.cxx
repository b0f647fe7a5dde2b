#include "Core/Alignment/BiasField.h"

#include <algorithm>
#include <array>

namespace innergs {
namespace {

constexpr int kHighest = 8;

} // namespace

void legendreProducts(const Vec3& unit, int degree, std::span<double> values) {
  std::array<std::array<double, kHighest + 1>, 3> p;
  for (int a = 0; a < 3; ++a) {
    p[a][0] = 1;
    p[a][1] = unit[a];
    for (int n = 2; n <= degree; ++n)
      p[a][n] = ((2 * n - 1) * unit[a] * p[a][n - 1] - (n - 1) * p[a][n - 2]) / n;
  }
  std::size_t at = 0;
  for (int total = 0; total <= degree; ++total)
    for (int i = 0; i <= total; ++i)
      for (int j = 0; i + j <= total; ++j)
        values[at++] = p[0][i] * p[1][j] * p[2][total - i - j];
}

Vec3 BiasField::unit(const Vec3& x) const {
  Vec3 u = toBox(x);
  for (double& c : u)
    c = std::clamp(c, -1.0, 1.0);
  return u;
}

double BiasField::logAt(const Vec3& x) const {
  if (coefficients.empty()) return 0;
  std::array<double, legendreCount(kHighest)> products;
  legendreProducts(unit(x), degree, products);
  double sum = 0;
  for (std::size_t n = 0; n < coefficients.size(); ++n)
    sum += coefficients[n] * products[n];
  return std::clamp(sum, lowestLog, highestLog);
}

BiasField biasFieldOver(const GridGeometry& box, int degree) {
  Vec3 low, high;
  for (int a = 0; a < 3; ++a) {
    low[a] = -0.5;
    high[a] = static_cast<double>(box.size[a]) - 0.5;
  }
  return biasFieldOver(box, low, high, degree);
}

BiasField biasFieldOver(const GridGeometry& grid, const Vec3& low, const Vec3& high, int degree) {
  BiasField field;
  field.degree = degree;
  Vec3 scale, offset;
  for (int a = 0; a < 3; ++a) {
    scale[a] = 2 / (high[a] - low[a]);
    offset[a] = -1 - scale[a] * low[a];
  }
  field.toBox = Affine3{diagonal(scale), offset} * inverse(grid.indexToWorld());
  return field;
}

} // namespace innergs
