#include "Core/Acquisition/SampleGrid.h"

#include "Core/Image/GridGeometry.h"

namespace innergs {

SampleGrid sampleGridOf(const GridGeometry& grid, const Affine3& modelToWorld) {
  return sampleGridOf(grid, modelToWorld, 0, grid.size[2]);
}

SampleGrid sampleGridOf(const GridGeometry& grid, const Affine3& modelToWorld, std::int64_t first,
                        std::int64_t last) {
  SampleGrid samples;
  samples.indexToModel = inverse(modelToWorld) * grid.indexToWorld();
  samples.nx = static_cast<int>(grid.size[0]);
  samples.ny = static_cast<int>(grid.size[1]);
  for (std::int64_t k = first; k < last; ++k)
    samples.z.push_back(static_cast<double>(k));
  return samples;
}

} // namespace innergs
