#pragma once
#include "Core/Image/GridGeometry.h"

namespace innergs {

/// The lattice between a scan's slices that a prediction fills: the scan's own in-plane, as fine along the
/// slice axis as its pixels, over all of its box; where `wanted` runs along the scan's slice axis and is
/// about as fine, in step with it.
GridGeometry predictionLattice(const GridGeometry& stack, const GridGeometry& wanted);

} // namespace innergs
