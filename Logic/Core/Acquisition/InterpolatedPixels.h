#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <array>

namespace innergs {

/// How much larger than the stored pixels those acquired were, along I and J: scanners interpolate images in
/// plane, mostly by zero filling of k-space. At least 1.25 where it is clear: larger pixels show the images
/// to a fifth of their noise. Otherwise 1, as for stacks without noise, with voxels that are not finite, or
/// of less than 32 pixels along an axis. Throws Error(Cancelled).
std::array<double, 2> interpolationFactors(const Stack& stack, ThreadPool& pool);

/// The stack in pixels larger by these factors along I and J, over the same area but for a part of a pixel,
/// interpolated by a windowed sinc (Lanczos, six lobes): without loss if it was interpolated. Observed are
/// pixels of which all was observed.
Stack withLargerPixels(const Stack& stack, const std::array<double, 2>& factors, ThreadPool& pool);

} // namespace innergs
