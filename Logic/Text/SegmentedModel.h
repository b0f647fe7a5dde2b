#pragma once
#include "Core/Features/Teacher.h"
#include "Core/Motion/DynamicField.h"

#include <memory>

namespace innergs {

/// What segments are found in: a model with features or a moving scan's at a time.
struct SegmentedModel {
  std::shared_ptr<const GaussianField> field;   // of a moving scan unused
  std::shared_ptr<const FeatureModel> features; // null: none
  std::shared_ptr<const DynamicField> moving;   // null: it does not move
  double time = 0;                              // s
  bool operator==(const SegmentedModel&) const = default;
};

/// Features for the model's Gaussians, those of a moving scan learned from the teacher at the model's
/// time. Throws as trainFrom() does.
FeatureModel trainFrom(const SegmentedModel& model, const Teacher& teacher,
                       const FeatureTraining& training = {});

} // namespace innergs
