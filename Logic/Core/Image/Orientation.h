#pragma once
#include "Core/Image/Linear.h"

#include <array>
#include <string>

namespace innergs {

/// The patient axis (0, 1, 2: x, y, z) nearest to each grid axis: the permutation with the largest sum of
/// |cosines|.
std::array<int, 3> nearestAxes(const Mat3& direction);

/// The direction in which each grid axis grows, for directions in LPS: "LPS" = I to the left, J to the
/// back (posterior), K to the head (superior). Each patient axis occurs once, however oblique the grid.
std::string orientationCode(const Mat3& direction);

} // namespace innergs
