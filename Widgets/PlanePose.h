#pragma once
#include "Core/Image/Linear.h"

#include <QString>

#include <array>
#include <optional>

class vtkMatrix4x4;

namespace innergs::ui {

/// The planes of 3D Slicer's slice views: x right and y up on the screen, z along the normal, in RAS. Axial
/// (L, A, S) is left-handed there, coronal (L, S, A) and sagittal (P, S, L) are right-handed.
enum class PlaneOrientation { Axial, Coronal, Sagittal };
/// Columns: right, up, normal.
Mat3 axesOf(PlaneOrientation orientation);

/// Degrees, in (−180, 180].
struct PlaneAngles {
  double aboutHorizontal = 0, aboutVertical = 0; // tilts about the orientation's x and the tilted y
  double inPlane = 0;                            // about the plane's own normal
  bool operator==(const PlaneAngles&) const = default;
};

/// The position of a plane: an orientation, rotated by angles, through a point. axes() =
/// axesOf(orientation)·Rx·Ry·Rz, so the two tilts alone define the plane, and the in-plane angle its rotation
/// on the screen.
struct PlanePose {
  PlaneOrientation orientation = PlaneOrientation::Axial;
  bool reversed = false; // the normal is opposite to the orientation's
  PlaneAngles angles;
  Vec3 origin{0, 0, 0}; // RAS mm: the centre of the view, and of rotations

  Mat3 axes() const;
  Vec3 normal() const { return column(axes(), 2); }
  /// Whether all angles are 0.
  bool isStraight() const;
  /// The RAS position of a point (mm) in plane coordinates.
  Vec3 toRAS(double right, double up, double along = 0) const;
  /// mm along the normal from the RAS origin, like a slice view's offset.
  double position() const { return dot(normal(), origin); }
  void setPosition(double position);
  /// Rotates by degrees about its own axis 0 (right), 1 (up) or 2 (normal), through its origin.
  void turn(int axis, double degrees);
  /// Moves by mm along its own axes.
  void move(double right, double up, double along);
  bool operator==(const PlanePose&) const = default;
};

/// The pose of a slice node's SliceToRAS, with the nearest orientation; ignores column lengths and removes
/// shear. Nothing for a matrix without a plane (singular, not finite).
std::optional<PlanePose> poseOf(vtkMatrix4x4* planeToRAS);
void toMatrix(const PlanePose& pose, vtkMatrix4x4* planeToRAS);

/// The box (mm; xmin, xmax, ymin, ...) in plane coordinates that contains a RAS box.
std::array<double, 6> extentOf(const PlanePose& pose, const std::array<double, 6>& bounds);

/// "R", "L", "A", "P", "S", "I" for a RAS direction; for oblique ones all significant letters, the largest
/// first ("AL").
QString directionLetters(const Vec3& direction);
/// "R 12.3, A 4.0, I 5.6": each coordinate with the letter of its sign.
QString positionText(const Vec3& ras);

} // namespace innergs::ui
