#pragma once
#include "Core/Features/FeatureModel.h"
#include "Core/Job/ReconstructionJob.h"

#include <memory>

namespace innergs::mrml {

/// A model moved by an affine map (LPS mm), and the part of the map that could not be applied: map = rest ∘
/// (what was applied).
struct HardenedModel {
  std::shared_ptr<const Model> model;
  std::shared_ptr<const FeatureModel> features; // null: there were none
  Affine3 rest;
  bool complete = true; // rest is the identity
};

/// Moves means, covariances, slopes, domain, support, residual grid and the features' grids by rotations,
/// shifts, scalings and mirrorings along the axes of the model's grids, or by anything when it has no
/// grid. A shear of a grid stays in `rest`. An interrupted fit cannot continue from a moved model.
/// Throws Error when the map cannot be inverted or takes the model out of range.
HardenedModel harden(const Model& model, const FeatureModel* features, const Affine3& map);

} // namespace innergs::mrml
