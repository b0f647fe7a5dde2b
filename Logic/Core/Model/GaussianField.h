#pragma once
#include "Core/Image/Volume.h"
#include "Core/Model/Gaussian.h"

#include <optional>
#include <string>

namespace innergs {

/// "normalised", "additive" or "alpha", as written in files, reports and options.
const char* blendingName(Blending blending);
/// Nothing for any other name.
std::optional<Blending> blendingNamed(const std::string& name);

/// A continuous volume made of Gaussians.
struct GaussianField {
  Blending blending = Blending::Normalised;
  bool linearIntensity = false;
  double epsilon = 1e-3;                          // ε of the normalised blending
  double cutoff = 3.0;                            // Mahalanobis radius at which p reaches 0
  Affine3 modelToWorld;                           // rigid: model frame (mm) → LPS (mm)
  double intensityScale = 1, intensityOffset = 0; // scanner value = scale·I + offset
  GridGeometry domain; // the fitted region; outside it there is no value (I = 0); no voxels = unlimited
  std::vector<Gaussian> gaussians;
  Volume residual; // what the Gaussians miss of the data (data consistency): patient-space grid, units of
                   // I, added by trilinear interpolation inside its box; no voxels = none

  Mask support;   // of a masked fit: the voxels that have values, on the domain's grid cropped to the mask's
                  // box; no voxels = the whole domain
  float fill = 0; // scanner units: the value outside the support
  std::optional<ValueRange> range; // of the fitted voxels; queries stay within it

  std::int64_t size() const { return static_cast<std::int64_t>(gaussians.size()); }
  /// The grid that has values: the support's or, without one, the domain. The default for resampling.
  const GridGeometry& region() const { return support.voxels.empty() ? domain : support.geometry; }
};

/// Throws Error(FileFormat) if a field cannot be rendered (non-finite or absurd parameters, broken frame).
void checkField(const GaussianField& field);

} // namespace innergs
