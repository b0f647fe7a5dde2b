#include "Core/Render/FieldGradient.h"

namespace innergs {

ChainRules chainRules(Blending blending, bool linear, const SampleGrid& grid, const ClosedFormPsf& psf) {
  ChainRules rules;
  rules.linear = linear;
  rules.alpha = blending == Blending::Alpha;
  rules.psf = psf;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      rules.toModel[3 * i + j] = static_cast<float>(grid.indexToModel.linear[i][j]);
  return rules;
}

FieldGradient::FieldGradient(const GaussianField& field, const SampleGrid& grid, const ClosedFormPsf& psf)
    : rules_(chainRules(field.blending, field.linearIntensity, grid, psf)) {}

void FieldGradient::add(const Gaussian& g, const math::Moments<float>& moments, float* gradient) const {
  addParameterGradient(g, moments, rules_, gradient);
}

} // namespace innergs
