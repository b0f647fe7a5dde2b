#include "CLI/ColorMaps.h"

#include <algorithm>
#include <cmath>

namespace innergs::cli {

Colour grey(double value) {
  if (!std::isfinite(value)) return kPictureBackground;
  const auto level = static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0)));
  return {level, level, level};
}

Colour heat(double value) {
  if (!std::isfinite(value)) return kPictureBackground;
  Colour colour;
  for (int c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(std::lround(255 * std::clamp(3 * value - c, 0.0, 1.0)));
  return colour;
}

GreyScale::GreyScale(const Volume& volume) {
  std::vector<float> finite;
  for (const float v : volume.voxels)
    if (std::isfinite(v)) finite.push_back(v);
  const auto quantile = [&](double q) {
    const auto nth = finite.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(finite.size() - 1));
    std::nth_element(finite.begin(), nth, finite.end());
    return static_cast<double>(*nth);
  };
  low_ = quantile(0.001);
  high_ = std::max(quantile(0.999), low_ + 1e-12);
}

} // namespace innergs::cli
