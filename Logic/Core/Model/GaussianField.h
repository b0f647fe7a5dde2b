#pragma once
#include "Core/Image/Volume.h"
#include "Core/Model/Gaussian.h"

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
  GridGeometry domain; // the region that was fitted, outside which there is no value (I = 0); no voxels =
                       // unlimited
  std::vector<Gaussian> gaussians;
  Volume residual; // what the data still demand beyond the Gaussians (data consistency): patient-space
                   // lattice, units of I, added by trilinear interpolation inside its box; no voxels = none

  Mask support; // of a masked fit: voxels of the domain's lattice, cut to the mask's box, in which there are
                // values; no voxels = in all of the domain
  float fill = 0;                  // scanner units: the value outside the support
  std::optional<ValueRange> range; // of the voxels that were fitted: values asked for stay within it

  std::int64_t size() const { return static_cast<std::int64_t>(gaussians.size()); }
  /// Where there are values: the support's lattice or, without one, the domain. The default for resampling.
  const GridGeometry& region() const { return support.voxels.empty() ? domain : support.geometry; }
};

/// Throws Error(FileFormat) when a field cannot be rendered (non-finite or absurd parameters, broken frame).
void checkField(const GaussianField& field);

} // namespace innergs
