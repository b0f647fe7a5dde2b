#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <span>

namespace innergs {

/// Robust standard deviation of the noise, in the image's units: median absolute second difference in-plane,
/// inside `mask` if it is given and large enough. 0 for label images: two values, or mostly constant regions.
double estimateNoise(const Volume& volume, std::span<const std::uint8_t> mask = {});

} // namespace innergs
