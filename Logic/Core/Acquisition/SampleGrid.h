#pragma once
#include "Core/Image/Linear.h"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace innergs {

struct GridGeometry;

/// Where a field is evaluated: nx×ny points on parallel planes at continuous index z, all in index
/// coordinates (x, y, z).
struct SampleGrid {
  Affine3 indexToModel; // mm, model frame
  int nx = 0, ny = 0;
  std::vector<double> z; // ascending

  int planes() const { return static_cast<int>(z.size()); }
  /// Rows are padded so that full SIMD vectors never cross their end.
  int stride() const { return (nx + 15) / 16 * 16; }
  std::size_t planeSize() const { return static_cast<std::size_t>(stride()) * ny; }
  std::size_t bufferSize() const { return planeSize() * z.size(); }
};

/// The voxel centres of a grid, or of its slices from `first` up to `last`, seen from a model.
SampleGrid sampleGridOf(const GridGeometry& grid, const Affine3& modelToWorld);
SampleGrid sampleGridOf(const GridGeometry& grid, const Affine3& modelToWorld, std::int64_t first,
                        std::int64_t last);

} // namespace innergs
