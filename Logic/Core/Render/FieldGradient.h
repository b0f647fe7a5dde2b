#pragma once
#include "Core/Render/ChainRule.h"
#include "Core/Render/Projected.h"

namespace innergs {

ChainRules chainRules(Blending blending, bool linear, const SampleGrid& grid, const ClosedFormPsf& psf);

/// Applies addParameterGradient() to the Gaussians of a field on a grid.
class FieldGradient {
public:
  FieldGradient(const GaussianField& field, const SampleGrid& grid, const ClosedFormPsf& psf);
  /// Adds to gradient[16], in the order of struct Gaussian.
  void add(const Gaussian& gaussian, const math::Moments<float>& moments, float* gradient) const;

private:
  ChainRules rules_;
};

} // namespace innergs
