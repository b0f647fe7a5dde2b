#pragma once
#include "Core/Render/Composite.h"

#include <memory>

namespace innergs {

/// Renders fields onto one lattice and gathers gradients from it. Buffers are [plane][row][stride]; `weights`
/// holds W, `numerators` N. Alpha blending: what is transmitted behind all Gaussians, and I.
class LatticeRenderer {
public:
  /// scratch: shared by renderers that take turns, each doing forward() and backward() in one go; null: its
  /// own.
  using Scratch = std::shared_ptr<std::vector<Projected>>;
  LatticeRenderer(Lattice lattice, const KernelSet& kernels, ThreadPool& pool, ClosedFormPsf psf = {},
                  Scratch scratch = {});

  const Lattice& lattice() const { return lattice_; }

  /// W = Σ w p and N = Σ w p (c + g·d) (or the transmittance and I) into the caller's buffers (bufferSize()
  /// each, overwritten).
  void forward(const GaussianField& field, std::span<const float> values, float* weights, float* numerators);

  /// Adds dL/d(parameters) of every Gaussian to `gradient`, 16 floats each in the order of struct Gaussian,
  /// from F0 and F1 (Docs/method.md; alpha: ∂L/∂I and I) on the lattice. forward() must have been called with
  /// the same field.
  void backward(const GaussianField& field, const float* f0, const float* f1, std::span<float> gradient);

private:
  LatticeView view() const;

  Lattice lattice_;
  const KernelSet& kernels_;
  ThreadPool& pool_;
  ClosedFormPsf psf_;
  Tiles tiles_;
  Compositor compositor_;
  Scratch projected_;
};

} // namespace innergs
