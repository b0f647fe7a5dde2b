#pragma once

namespace innergs {

/// The greatest slice thickness over the distance of the slices: CT reconstructs 10 mm slices every 0.625 mm.
constexpr double kMostOverlap = 16;

} // namespace innergs
