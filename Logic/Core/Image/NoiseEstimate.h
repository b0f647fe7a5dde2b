#pragma once
#include "Core/Image/Volume.h"

#include <cstdint>
#include <span>

namespace innergs {

/// Robust standard deviation of white noise, in the image's units: median absolute second differences
/// in-plane, of neighbours and of pixels two apart, inside `mask` if it is given and large enough. The part
/// that grows with that distance as in images with a 1/f² spectrum (natural ones: Field 1987) is texture, not
/// noise. 0 for labelmaps: two values, or mostly constant regions. Of more than a million voxels, some rows
/// and slices are left out.
double estimateNoise(const Volume& volume, std::span<const std::uint8_t> mask = {});

/// The same from neighbours alone: noise and fine texture together. Positive for every image but label
/// images.
double estimateFineDetail(const Volume& volume, std::span<const std::uint8_t> mask = {});

/// The share of an image's fine detail (a ratio of standard deviations, 0 … 1) that the slices on either side
/// do not show: about 1 where slices have their own noise, less where they are smooth across (interpolated or
/// overlapping slices). 1 where too little is known.
double ownShareOfDetail(const Volume& volume, std::span<const std::uint8_t> mask = {});

} // namespace innergs
