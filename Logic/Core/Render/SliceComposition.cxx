#include "Core/Render/SliceComposition.h"

#include <algorithm>

namespace innergs {

void composeSlice(const Observation& o, int slice, const float* weights, const float* numerators,
                  const GaussianField& field, float* out) {
  const std::size_t n = o.sliceSize();
  const float epsilon = static_cast<float>(field.epsilon);
  const bool normalised = field.blending == Blending::Normalised;
  std::fill_n(out, n, 0.f);
  for (int q = 0; q < o.perSlice; ++q) {
    const auto [plane, share] = o.subPlanes[static_cast<std::size_t>(slice) * o.perSlice + q];
    const float* w = weights + plane * n;
    const float* c = numerators + plane * n;
    if (normalised)
      for (std::size_t i = 0; i < n; ++i)
        out[i] += share * c[i] / (w[i] + epsilon);
    else
      for (std::size_t i = 0; i < n; ++i)
        out[i] += share * c[i];
  }
}

} // namespace innergs
