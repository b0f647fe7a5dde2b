#pragma once
#include "Core/Image/Stack.h"

#include <span>
#include <stop_token>

namespace innergs {

/// How far values may reach beyond a mask, mm: one slice distance, the largest of the stacks.
double supportMargin(std::span<const Stack> stacks);

/// Where a fit inside a mask has values: of the lattice `domain` the voxels whose centre lies in the mask,
/// and those around the centres of observed voxels, no point on the stacks' lattices further away than
/// `margin` mm; cut to the box they fill. Stacks: as masked. Throws Error(NoData) when there is none,
/// Error(Cancelled).
Mask supportOf(const Mask& mask, std::span<const Stack> stacks, const GridGeometry& domain, double margin,
               const std::stop_token& stop = {});

} // namespace innergs
