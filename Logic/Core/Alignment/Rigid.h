#pragma once
#include "Core/Image/Linear.h"

namespace innergs {

/// The rotation by |turn| radians about turn (Rodrigues).
Mat3 rotation(const Vec3& turn);
/// Its inverse, for rotations by less than half a turn.
Vec3 rotationVector(const Mat3& rotation);
/// By how much it turns, degrees.
double angleOf(const Mat3& rotation);
/// x → centre + rotation(turn)·(x − centre) + shift.
Affine3 rigidAbout(const Vec3& centre, const Vec3& turn, const Vec3& shift);

} // namespace innergs
