#include "Widgets/PlanePose.h"

#include <QLocale>

#include <vtkMatrix4x4.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace innergs::ui {

namespace {

constexpr double perDegree = std::numbers::pi / 180;

Mat3 rotation(int axis, double degrees) {
  Mat3 r;
  const int i = (axis + 1) % 3, j = (axis + 2) % 3;
  // Multiples of 90° are exact, so that a plane set to 90° is one of the three standard ones.
  const double c =
      std::fmod(degrees, 180) == 0 || std::fmod(degrees, 90) != 0 ? std::cos(degrees * perDegree) : 0;
  const double s = std::fmod(degrees, 180) == 0 ? 0 : std::sin(degrees * perDegree);
  r[i][i] = c, r[i][j] = -s;
  r[j][i] = s, r[j][j] = c;
  return r;
}

Mat3 turned(const PlaneAngles& a) {
  return rotation(0, a.aboutHorizontal) * (rotation(1, a.aboutVertical) * rotation(2, a.inPlane));
}

double wrapped(double degrees) {
  const double r = std::remainder(degrees, 360);
  return r <= -180 ? r + 360 : r + 0.; // no −0
}

double distance(const PlaneAngles& a, const PlaneAngles& b) {
  return std::abs(wrapped(a.aboutHorizontal - b.aboutHorizontal)) +
         std::abs(wrapped(a.aboutVertical - b.aboutVertical)) + std::abs(wrapped(a.inPlane - b.inPlane));
}

/// The angles of a rotation; of the equivalent ones, those nearest to `last`.
PlaneAngles anglesOf(const Mat3& r, const PlaneAngles& last) {
  const auto degrees = [](double y, double x) { return wrapped(std::atan2(y, x) / perDegree); };
  PlaneAngles a;
  const double cosine = std::hypot(r[0][0], r[0][1]);
  a.aboutVertical = degrees(r[0][2], cosine);
  if (cosine < 1e-9) { // the first and the last axis coincide: keeps the last angle
    a.inPlane = last.inPlane;
    const double both = degrees(r[1][0], r[1][1]);
    a.aboutHorizontal = wrapped(r[0][2] > 0 ? both - a.inPlane : a.inPlane - both);
    return a;
  }
  a.inPlane = degrees(-r[0][1], r[0][0]);
  a.aboutHorizontal = degrees(-r[1][2], r[2][2]);
  const PlaneAngles other{wrapped(a.aboutHorizontal + 180), wrapped(180 - a.aboutVertical),
                          wrapped(a.inPlane + 180)};
  return distance(other, last) < distance(a, last) - 1e-6 ? other : a;
}

Mat3 base(PlaneOrientation orientation, bool reversed) {
  return reversed ? axesOf(orientation) * diagonal({1, 1, -1}) : axesOf(orientation);
}

} // namespace

Mat3 axesOf(PlaneOrientation orientation) {
  static const Mat3 axes[] = {Mat3{{{{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}},
                              Mat3{{{{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}}}},
                              Mat3{{{{0, 0, -1}, {-1, 0, 0}, {0, 1, 0}}}}};
  return axes[static_cast<int>(orientation)];
}

Mat3 PlanePose::axes() const {
  return base(orientation, reversed) * turned(angles);
}

bool PlanePose::isStraight() const {
  return !reversed && std::abs(angles.aboutHorizontal) < 1e-6 && std::abs(angles.aboutVertical) < 1e-6 &&
         std::abs(angles.inPlane) < 1e-6;
}

Vec3 PlanePose::toRAS(double right, double up, double along) const {
  return axes() * Vec3{right, up, along} + origin;
}

void PlanePose::setPosition(double position) {
  const Vec3 n = normal();
  origin = origin + (position - dot(n, origin)) * n;
}

void PlanePose::turn(int axis, double degrees) {
  angles = anglesOf(turned(angles) * rotation(axis, degrees), angles);
}

void PlanePose::move(double right, double up, double along) {
  origin = toRAS(right, up, along);
}

std::optional<PlanePose> poseOf(vtkMatrix4x4* planeToRAS) {
  if (!planeToRAS) return std::nullopt;
  PlanePose pose;
  Vec3 axis[3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      axis[c][r] = planeToRAS->GetElement(r, c);
    pose.origin[r] = planeToRAS->GetElement(r, 3);
  }
  for (const Vec3& v : {axis[0], axis[1], axis[2], pose.origin})
    for (const double x : v)
      if (!std::isfinite(x)) return std::nullopt;
  for (Vec3& v : axis) {
    if (!(norm(v) > 0)) return std::nullopt;
    v = (1 / norm(v)) * v;
  }
  axis[1] = axis[1] - dot(axis[0], axis[1]) * axis[0];
  const Vec3 across = cross(axis[0], axis[1]);
  const double along = dot(across, axis[2]); // sine of the angle between x and y; small for a bad matrix
  if (std::abs(along) < 1e-6) return std::nullopt;
  axis[1] = (1 / norm(axis[1])) * axis[1];
  axis[2] = ((along > 0 ? 1 : -1) / norm(across)) * across;
  Mat3 axes;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      axes[r][c] = axis[c][r];

  double best = -2;
  Mat3 rest;
  for (const auto orientation :
       {PlaneOrientation::Axial, PlaneOrientation::Coronal, PlaneOrientation::Sagittal}) {
    const bool reversed = determinant(axesOf(orientation)) * along < 0;
    const Mat3 r = transpose(base(orientation, reversed)) * axes;
    const double likeness = r[0][0] + r[1][1] + r[2][2];
    if (likeness < best + 1e-9) continue;
    best = likeness;
    pose.orientation = orientation;
    pose.reversed = reversed;
    rest = r;
  }
  pose.angles = anglesOf(rest, {});
  return pose;
}

void toMatrix(const PlanePose& pose, vtkMatrix4x4* planeToRAS) {
  const Mat3 axes = pose.axes();
  planeToRAS->Identity();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c)
      planeToRAS->SetElement(r, c, axes[r][c]);
    planeToRAS->SetElement(r, 3, pose.origin[r]);
  }
}

std::array<double, 6> extentOf(const PlanePose& pose, const std::array<double, 6>& bounds) {
  const Mat3 axes = pose.axes();
  std::array<double, 6> extent{};
  for (int a = 0; a < 3; ++a) {
    double middle = 0, half = 0;
    for (int r = 0; r < 3; ++r) {
      middle += axes[r][a] * (0.5 * (bounds[2 * r] + bounds[2 * r + 1]) - pose.origin[r]);
      half += std::abs(axes[r][a]) * 0.5 * (bounds[2 * r + 1] - bounds[2 * r]);
    }
    extent[2 * a] = middle - half;
    extent[2 * a + 1] = middle + half;
  }
  return extent;
}

QString directionLetters(const Vec3& direction) {
  const double length = norm(direction);
  std::array<std::pair<long, char>, 3> parts; // in millionths, so that equal ones compare equal
  for (int a = 0; a < 3; ++a)
    parts[a] = {std::lround(1e6 * std::abs(direction[a]) / length), direction[a] > 0 ? "RAS"[a] : "LPI"[a]};
  std::stable_sort(parts.begin(), parts.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  QString letters;
  for (const auto& [share, letter] : parts)
    if (share > 200000) letters += QLatin1Char(letter); // more than about 12° away from a right angle
  return letters;
}

QString positionText(const Vec3& ras) {
  QString text;
  for (int a = 0; a < 3; ++a) {
    if (a > 0) text += QStringLiteral(", ");
    text += QLatin1Char(ras[a] < 0 ? "LPI"[a] : "RAS"[a]);
    text += QLatin1Char(' ') + QLocale().toString(std::abs(ras[a]), 'f', 1);
  }
  return text;
}

} // namespace innergs::ui
