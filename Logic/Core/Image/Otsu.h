#pragma once
#include <span>

namespace innergs {

/// Otsu's threshold (Otsu 1979) of the finite values (256 bins between minimum and maximum); the foreground
/// lies above it. For a constant image, its value.
double otsuThreshold(std::span<const float> values);

/// Otsu's threshold, found again among the values below it while less than 1 % of the finite values lie above
/// it: metal or a few bright spots would pass for the foreground.
double foregroundThreshold(std::span<const float> values);

} // namespace innergs
