#include "Core/Acquisition/Lattice.h"

#include "Core/Image/GridGeometry.h"

namespace innergs {

Lattice latticeOf(const GridGeometry& grid, const Affine3& modelToWorld) {
  return latticeOf(grid, modelToWorld, 0, grid.size[2]);
}

Lattice latticeOf(const GridGeometry& grid, const Affine3& modelToWorld, std::int64_t first,
                  std::int64_t last) {
  Lattice lattice;
  lattice.indexToModel = inverse(modelToWorld) * grid.indexToWorld();
  lattice.nx = static_cast<int>(grid.size[0]);
  lattice.ny = static_cast<int>(grid.size[1]);
  for (std::int64_t k = first; k < last; ++k)
    lattice.z.push_back(static_cast<double>(k));
  return lattice;
}

} // namespace innergs
