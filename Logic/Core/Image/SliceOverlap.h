#pragma once

namespace innergs {

/// The largest ratio of slice thickness to slice distance: CT reconstructs 10 mm slices every 0.625 mm.
constexpr double kMostOverlap = 16;

} // namespace innergs
