#pragma once
#include "Core/Gaussian.h"
#include "Core/Volume.h"

#include <optional>
#include <string>

namespace innergs {

/// "normalised", "additive", "alpha": in files, reports and options.
const char* blendingName(Blending blending);
/// Nothing for any other word.
std::optional<Blending> blendingNamed(const std::string& name);

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
