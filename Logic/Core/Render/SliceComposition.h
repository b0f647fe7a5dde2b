#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Model/GaussianField.h"

namespace innergs {

/// Composes the slices as observed (Σ sub-plane weight · I) from W and N. out: [slice][ny][stride].
void composeSlice(const Observation& observation, int slice, const float* weights, const float* numerators,
                  const GaussianField& field, float* out);

} // namespace innergs
