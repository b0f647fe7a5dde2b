#pragma once
#include "Core/Image/GridGeometry.h"

namespace innergs {

/// The grid between a scan's slices that a prediction fills: the scan's own in-plane, as fine along the
/// slice axis as its pixels, over its whole box. If `wanted` is parallel to the scan's slice axis and not
/// much finer, its planes are among the grid's.
GridGeometry candidateGrid(const GridGeometry& stack, const GridGeometry& wanted);

} // namespace innergs
