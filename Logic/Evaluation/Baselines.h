#pragma once
#include "Core/Image/Stack.h"

#include <stop_token>

namespace innergs {

enum class Interpolation {
  Linear,
  Cubic,  // cubic B-spline through the samples (Unser 1999)
  Lanczos // windowed sinc, radius 4, weights summing to 1
};

/// A stack on another grid. weight: 1 inside the stack's box of voxel edges, 0 outside (with the value of
/// the nearest edge), in between where unobserved or non-finite voxels contribute.
struct Upsampled {
  Volume volume;
  std::vector<float> weight;
};

/// Interpolates a stack, as an image of point samples at its voxel centres, onto a grid of any
/// orientation. Unobserved and non-finite voxels first take the nearest observed value. threads: 0 = all
/// cores. Throws Error(InvalidArgument) for a stack with slice poses, what checkStack throws, and
/// Error(Cancelled) when stopped.
Upsampled upsample(const Stack& stack, const GridGeometry& grid, Interpolation kind, int threads = 0,
                   const std::stop_token& stop = {});

/// Weighted average of upsampled stacks; the plain average where all weights are 0.
Volume averageOf(std::span<const Upsampled> upsampled, const std::stop_token& stop = {});

/// The interpolated average of one or several stacks.
Volume averageUpsampled(std::span<const Stack> stacks, const GridGeometry& grid, Interpolation kind,
                        int threads = 0, const std::stop_token& stop = {});

} // namespace innergs
