#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// Blends scans into each other towards their edges, so that what they show differently leaves no step where
/// one of them ends: a voxel of `part` becomes w·own + (1 − w)·mean of the others there, where w falls from 1
/// to 0 over `width` (mm) before the faces of its scan, relative to that of the other that reaches farthest.
/// Reads observed voxels of the others by trilinear interpolation. Does nothing if one has poses. Throws
/// Error(Cancelled).
void blendEdges(std::span<Stack> scans, std::span<const std::size_t> part, double width, ThreadPool& pool);

} // namespace innergs
