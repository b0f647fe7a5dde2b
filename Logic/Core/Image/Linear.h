#pragma once
#include <array>
#include <cmath>

namespace innergs {

/// Small double-precision vectors, 3×3 matrices and affine maps x → linear·x + offset.
using Vec3 = std::array<double, 3>;

struct Mat3 {
  std::array<std::array<double, 3>, 3> m{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}; // m[row][column]
  std::array<double, 3>& operator[](int row) { return m[row]; }
  const std::array<double, 3>& operator[](int row) const { return m[row]; }
  bool operator==(const Mat3&) const = default;
};

inline Vec3 operator+(const Vec3& a, const Vec3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Vec3 operator-(const Vec3& a, const Vec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Vec3 operator*(double s, const Vec3& a) {
  return {s * a[0], s * a[1], s * a[2]};
}
inline bool isFinite(const Vec3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}
inline double dot(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Vec3 cross(const Vec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline double norm(const Vec3& a) {
  return std::sqrt(dot(a, a));
}

inline Vec3 operator*(const Mat3& a, const Vec3& x) {
  return {dot(a[0], x), dot(a[1], x), dot(a[2], x)};
}
inline Mat3 operator*(const Mat3& a, const Mat3& b) {
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return c;
}
inline Mat3 transpose(const Mat3& a) {
  Mat3 t;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      t[i][j] = a[j][i];
  return t;
}
inline Mat3 diagonal(const Vec3& d) {
  Mat3 a;
  for (int i = 0; i < 3; ++i)
    a[i][i] = d[i];
  return a;
}
inline Vec3 column(const Mat3& a, int j) {
  return {a[0][j], a[1][j], a[2][j]};
}
inline double determinant(const Mat3& a) {
  return dot(a[0], cross(a[1], a[2]));
}
/// Inverse by cofactors; the determinant must not be zero.
inline Mat3 inverse(const Mat3& a) {
  const Vec3 r0 = cross(a[1], a[2]), r1 = cross(a[2], a[0]), r2 = cross(a[0], a[1]);
  const double s = 1.0 / dot(a[0], r0);
  Mat3 c;
  for (int i = 0; i < 3; ++i)
    c[i] = {s * r0[i], s * r1[i], s * r2[i]};
  return c;
}

struct Affine3 {
  Mat3 linear;
  Vec3 offset{0, 0, 0};
  Vec3 operator()(const Vec3& x) const { return linear * x + offset; }
  bool operator==(const Affine3&) const = default;
};
/// (a * b)(x) = a(b(x)).
inline Affine3 operator*(const Affine3& a, const Affine3& b) {
  return {a.linear * b.linear, a(b.offset)};
}
inline Affine3 inverse(const Affine3& a) {
  const Mat3 inv = inverse(a.linear);
  return {inv, -1.0 * (inv * a.offset)};
}

} // namespace innergs
