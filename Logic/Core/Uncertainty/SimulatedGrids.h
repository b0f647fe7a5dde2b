#pragma once
#include "Core/Image/Stack.h"

#include <span>

namespace innergs {

/// The largest slice distance or thickness, mm.
double coarsestSlices(std::span<const Stack> stacks);

/// The grid that ErrorTransfer simulates scans of: a cube around a place (LPS mm) with the first stack's
/// axes.
GridGeometry simulationGrid(std::span<const Stack> stacks, const Vec3& middle);

/// The parts of the stacks inside `grid`, without voxels. posed: with the poses of their slices.
std::vector<Stack> simulatedGrids(std::span<const Stack> stacks, const GridGeometry& grid,
                                  bool posed = false);

} // namespace innergs
