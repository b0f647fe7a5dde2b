#pragma once
#include "Core/Base/Parallel.h"
#include "Evaluation/Baselines.h"

#include <memory>

namespace innergs {

/// ITK's interpolators (linear, B-spline of order 3, windowed sinc with a Lanczos window of radius 4), for
/// grids at any angle to each other. Clamps indices beyond the outermost voxel centres.
std::vector<float> resampleWithItk(const Volume& image, const GridGeometry& grid, Interpolation kind,
                                   ThreadPool& pool);

/// Cubic B-splines through an image's samples, made once and read often.
class ItkCubic {
public:
  explicit ItkCubic(const Volume& image);
  ~ItkCubic();
  /// On a grid of any orientation; as above beyond the image.
  std::vector<float> on(const GridGeometry& grid, ThreadPool& pool) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace innergs
