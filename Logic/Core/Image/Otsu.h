#pragma once
#include <span>

namespace innergs {

/// Otsu's threshold of the finite values (256 bins between minimum and maximum); the foreground lies above
/// it. For a constant image, its value.
double otsuThreshold(std::span<const float> values);

} // namespace innergs
