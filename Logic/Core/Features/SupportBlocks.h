#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Features/LabelCompletion.h"

namespace innergs {

/// The blocks of 6 voxels along an edge, on the grid of some labels, in which or within 4 voxels of which
/// a class has more than 2 % of a voxel.
ClassSupport supportOf(const GridGeometry& grid, const std::vector<SoftLabel>& labels, int classes,
                       ThreadPool& pool);

} // namespace innergs
