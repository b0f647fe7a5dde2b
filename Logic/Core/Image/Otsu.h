#pragma once
#include <span>

namespace innergs {

/// Otsu's threshold over the finite values (256 bins between minimum and maximum): foreground is what lies
/// above. A constant image gives its value.
double otsuThreshold(std::span<const float> values);

} // namespace innergs
