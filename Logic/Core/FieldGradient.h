#pragma once
#include "Core/GaussianMath.h"
#include "Core/Projected.h"

namespace innergs {

/// Chain rule from a Gaussian's moments on a lattice to its 15 parameters (Docs/method.md; closed-form PSF:
/// through Σ_obs = Σ + B and the factor √(det Σ / det Σ_obs)).
class FieldGradient {
public:
  FieldGradient(const GaussianField& field, const Lattice& lattice, const ClosedFormPsf& psf);
  /// Adds to gradient[16], in the order of struct Gaussian.
  void add(const Gaussian& gaussian, const math::Moments<float>& moments, float* gradient) const;

private:
  float toModel_[9];
  bool linear_, alpha_;
  ClosedFormPsf psf_;
};

} // namespace innergs
