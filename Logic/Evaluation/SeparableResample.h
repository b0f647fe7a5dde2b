#pragma once
#include "Core/Base/Parallel.h"
#include "Evaluation/Baselines.h"

#include <optional>

namespace innergs {

/// How the axes of two aligned grids correspond: index along the image's axis `axis[a]` = offset[a] +
/// scale[a] · index along the grid's axis a.
struct AxisMap {
  std::array<int, 3> axis;
  Vec3 offset, scale;
};

/// nullopt if the grids are oblique to each other (by more than 1e-4 voxel across the box).
std::optional<AxisMap> alignedAxes(const GridGeometry& image, const GridGeometry& grid);

/// Interpolates axis by axis: the same result as the tensor-product kernel with a fraction of its taps.
/// Clamps indices beyond the outermost voxel centres.
std::vector<float> resampleAligned(const Volume& image, const GridGeometry& grid, const AxisMap& map,
                                   Interpolation kind, ThreadPool& pool);

/// Weights of the Lanczos kernel (radius 4) at fraction f in [0, 1) after the fourth of eight samples; they
/// sum to 1.
std::array<double, 8> lanczosWeights(double fraction);

} // namespace innergs
