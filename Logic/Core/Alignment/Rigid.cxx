#include "Core/Alignment/Rigid.h"

#include <numbers>

namespace innergs {

Mat3 rotation(const Vec3& turn) {
  const double angle = norm(turn);
  if (angle < 1e-15) return {};
  const Vec3 u = (1 / angle) * turn;
  const double c = std::cos(angle), s = std::sin(angle);
  Mat3 r;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b)
      r[a][b] = (a == b ? c : 0) + (1 - c) * u[a] * u[b];
  r[0][1] -= s * u[2], r[0][2] += s * u[1], r[1][2] -= s * u[0];
  r[1][0] += s * u[2], r[2][0] -= s * u[1], r[2][1] += s * u[0];
  return r;
}

Vec3 rotationVector(const Mat3& r) {
  const Vec3 axis{0.5 * (r[2][1] - r[1][2]), 0.5 * (r[0][2] - r[2][0]), 0.5 * (r[1][0] - r[0][1])};
  const double sine = norm(axis), cosine = 0.5 * (r[0][0] + r[1][1] + r[2][2] - 1);
  return (sine > 1e-12 ? std::atan2(sine, cosine) / sine : 1) * axis;
}

double angleOf(const Mat3& r) {
  return norm(rotationVector(r)) * 180 / std::numbers::pi;
}

Affine3 rigidAbout(const Vec3& centre, const Vec3& turn, const Vec3& shift) {
  const Mat3 r = rotation(turn);
  return {r, centre + shift - r * centre};
}

} // namespace innergs
