#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <span>

namespace innergs {

/// Robust standard deviation of the noise, in the image's units: median absolute second difference in-plane,
/// inside `mask` if given and large enough. 0 for images of labels: two values, or mostly constant
/// structures.
double estimateNoise(const Volume& volume, std::span<const std::uint8_t> mask = {});

} // namespace innergs
