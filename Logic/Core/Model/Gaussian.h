#pragma once
#include <cstdint>

namespace innergs {

enum class Blending {
  Normalised, // I = Σ w (c + g·d) p / (Σ w p + ε)
  Additive,   // I = Σ w (c + g·d) p
  Alpha // I = Σ a c Π_{j<i} (1 − a_j), a = α p, sorted by |t − μ_t|, as in the paper. Depends on the slicing
        // direction: a point has one value per direction
};

/// One Gaussian, 64 bytes: p(x) = exp(−½ dᵀ Σ⁻¹ d) − exp(−½ cutoff²), or 0 where that is negative (so p is
/// continuous at the cut-off), d = x − mean, Σ = R(q)·diag(e^(2·logScale))·R(q)ᵀ (Kerbl et al. 2023).
struct Gaussian {
  float mean[3];       // mm, model frame
  float logScale[3];   // ln mm
  float quaternion[4]; // w, x, y, z; normalised on use
  float logWeight;     // w = e^logWeight (additive: also a factor of the amplitude); alpha: logit of α
  float intensity;     // c, in units of the field's intensity map
  float slope[3];      // g, per mm, model frame; 0 unless the field has linearIntensity
  float reserved;      // 0
};
static_assert(sizeof(Gaussian) == 64);

} // namespace innergs
