#pragma once
#include "Core/Render/Composite.h"
#include "Core/Render/Projected.h"

#include <memory>

namespace innergs {

/// Renders fields onto one grid and gathers gradients from it. Buffers are [plane][row][stride]; `weights`
/// holds W and `numerators` N (alpha blending: the transmittance behind all Gaussians, and I).
class GridRenderer {
public:
  /// What forward() leaves for backward(): large, so renderers that take turns, each doing both in one go,
  /// share it; null: its own.
  struct Buffers {
    NearGaussians near; // or all; `number` is then empty
    Tiles tiles;
  };
  using Scratch = std::shared_ptr<Buffers>;
  GridRenderer(SampleGrid grid, const KernelSet& kernels, ThreadPool& pool, ClosedFormPsf psf = {},
               Scratch scratch = {});

  const SampleGrid& grid() const { return grid_; }

  /// Writes W = Σ w p and N = Σ w p (c + g·d) (alpha: transmittance and I) to the caller's buffers, each of
  /// bufferSize(), overwriting them. blocks: measured on this field; they save time on a grid that shows few
  /// of its Gaussians.
  void forward(const GaussianField& field, std::span<const float> values, float* weights, float* numerators,
               const GaussianBlocks* blocks = nullptr);

  /// Adds dL/d(parameters) of every Gaussian to `gradient`, 16 floats each in the order of struct Gaussian,
  /// from F0 and F1 (Docs/method.md; alpha: ∂L/∂I and I) on the grid. Call forward() with the same field
  /// first.
  void backward(const GaussianField& field, const float* f0, const float* f1, std::span<float> gradient);

private:
  GridView view() const;

  SampleGrid grid_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  ClosedFormPsf psf_;
  Compositor compositor_;
  Scratch scratch_;
};

} // namespace innergs
