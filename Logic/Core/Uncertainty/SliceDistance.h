#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// How far each voxel of a grid lies from the nearest observed slice: the distance along the slice's
/// normal to its middle, as a share of half the slice distance. Infinite where no slice lies within 1.5 slice
/// distances.
std::vector<float> sliceDistances(const GridGeometry& grid, std::span<const Stack> stacks, ThreadPool& pool);

/// 1 where a voxel's centre lies within the thickness of an observed slice (at least a voxel thick), 0 where
/// nothing was measured: between slices, outside, held out, masked.
std::vector<std::uint8_t> measuredVoxels(const GridGeometry& grid, std::span<const Stack> stacks,
                                         ThreadPool& pool);

} // namespace innergs
