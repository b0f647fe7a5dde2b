#pragma once
#include "Core/Base/Parallel.h"
#include "Evaluation/Baselines.h"

namespace innergs {

/// ITK's interpolators (linear, B-spline of order 3, windowed sinc with a Lanczos window of radius 4), for
/// lattices at any angle to each other. Indices beyond the outermost voxel centres are clamped to them.
std::vector<float> resampleWithItk(const Volume& image, const GridGeometry& grid, Interpolation kind,
                                   ThreadPool& pool);

} // namespace innergs
