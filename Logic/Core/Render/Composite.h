#pragma once
#include "Core/Render/Tiles.h"

namespace innergs {

/// Alpha-blends the planes of a grid by tiles (Kerbl et al. 2023), each plane in its own depth order: nearest
/// centre first, |z − μ_z|, ties by index. One task owns a tile of one plane; a Gaussian's gradient is the
/// sum of its tiles' moments in a fixed order.
class Compositor {
public:
  Compositor(const GridView& grid, const KernelSet& kernels) : kernels_(kernels), tiles_(grid, 1) {}

  /// Writes the transmittance behind all Gaussians, and I, to the grid's buffers (overwritten).
  void forward(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool,
               float* transmittance, float* image);

  /// Backward pass from r = ∂L/∂I and I, after forward() with the same Gaussians. moments() has the result.
  void backward(std::span<const Projected> gaussians, const GridView& grid, ThreadPool& pool, const float* r,
                const float* image);
  math::Moments<float> moments(std::span<const Projected> gaussians, const GridView& grid,
                               std::int64_t gaussian) const;

private:
  const KernelSet& kernels_;
  Tiles tiles_;
  std::vector<std::int64_t> first_; // of a Gaussian's slots, one for each tile it reaches
  std::vector<math::PlaneMoments<float>> slots_;
};

} // namespace innergs
