#pragma once
#include "Core/Volume.h"

#include <optional>
#include <string>

namespace innergs {

enum class Blending {
  Normalised, // I = Σ w (c + g·d) p / (Σ w p + ε)
  Additive,   // I = Σ w (c + g·d) p
  Alpha // I = Σ a c Π_{j<i} (1 − a_j), a = α p, sorted by |t − μ_t|: the paper's. Depends on the slice's
        // plane, so a point has a value per slicing direction
};
/// "normalised", "additive", "alpha": in files, reports and options.
const char* blendingName(Blending blending);
/// Nothing for any other word.
std::optional<Blending> blendingNamed(const std::string& name);

/// One Gaussian, 64 bytes: p(x) = exp(−½ dᵀ Σ⁻¹ d) − exp(−½ cutoff²), 0 where that is negative (so that
/// nothing jumps at the cut-off), d = x − mean, Σ = R(q)·diag(e^(2·logScale))·R(q)ᵀ.
struct Gaussian {
  float mean[3];       // mm, model frame
  float logScale[3];   // ln mm
  float quaternion[4]; // w, x, y, z; normalised where used
  float logWeight;     // w = e^logWeight (additive: part of the amplitude as well); alpha: logit of α
  float intensity;     // c, in units of the field's intensity map
  float slope[3];      // g, per mm, model frame; 0 unless the field has linearIntensity
  float reserved;      // 0
};
static_assert(sizeof(Gaussian) == 64);

/// A continuous volume made of Gaussians.
struct GaussianField {
  Blending blending = Blending::Normalised;
  bool linearIntensity = false;
  double epsilon = 1e-3;                          // ε of the normalised blending
  double cutoff = 3.0;                            // Mahalanobis radius at which p reaches 0
  Affine3 modelToWorld;                           // rigid: model frame (mm) → LPS (mm)
  double intensityScale = 1, intensityOffset = 0; // scanner value = scale·I + offset
  GridGeometry domain; // the region that was fitted, outside which there is no value (I = 0);
                       // the default grid for resampling; no voxels = unlimited
  std::vector<Gaussian> gaussians;
  Volume detail; // what the data still demand beyond the Gaussians (data consistency): patient-space lattice,
                 // units of I, added by trilinear interpolation inside its box; no voxels = none

  std::int64_t size() const { return static_cast<std::int64_t>(gaussians.size()); }
};

/// Throws Error(FileFormat) when a field cannot be rendered (non-finite or absurd parameters, broken frame).
void checkField(const GaussianField& field);

} // namespace innergs
