#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <stop_token>

namespace innergs {

/// How far (mm) values extend beyond a mask: the largest slice distance of the stacks.
double supportMargin(std::span<const Stack> stacks);

/// Where a fit inside masks has values, on the grid `domain`: voxels whose centre lies in one of them, and
/// those around the centres of observed voxels, so far that no point on the stacks' grids with a value is
/// more than `margin` mm away; cropped to its bounding box. Stacks: as masked. Throws Error(NoData) if it is
/// empty, Error(Cancelled) when stopped.
Mask supportOf(std::span<const Mask> masks, std::span<const Stack> stacks, const GridGeometry& domain,
               double margin, const std::stop_token& stop = {});

} // namespace innergs
