#pragma once
#include "Core/Image/GridGeometry.h"

#include <limits>
#include <span>
#include <vector>

namespace innergs {

/// The number of products of Legendre polynomials in three coordinates of at most that degree in total.
constexpr int legendreCount(int degree) {
  return (degree + 1) * (degree + 2) * (degree + 3) / 6;
}

/// These products at a point of [−1, 1]³, lower total degrees first; the first is 1. values:
/// [legendreCount(degree)].
void legendreProducts(const Vec3& unit, int degree, std::span<double> values);

/// A smooth factor of brightness over space: the exponential of a polynomial, constant beyond its box along
/// each axis and held to a range.
struct BiasField {
  Affine3 toBox; // LPS mm → [−1, 1]³
  int degree = 0;
  std::vector<double> coefficients; // [legendreCount(degree)]; none: 1 everywhere
  double lowestLog = -std::numeric_limits<double>::infinity(), highestLog = -lowestLog;

  Vec3 unit(const Vec3& x) const;    // clamped
  double logAt(const Vec3& x) const; // x: LPS mm
};

/// One over a grid's box, or the part of it between two of its indices, without coefficients.
BiasField biasFieldOver(const GridGeometry& box, int degree);
BiasField biasFieldOver(const GridGeometry& grid, const Vec3& low, const Vec3& high, int degree);

} // namespace innergs
