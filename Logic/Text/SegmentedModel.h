#pragma once
#include "Core/Features/Teacher.h"
#include "Core/Motion/DynamicField.h"

#include <memory>

namespace innergs {

/// What segments are found in: a model with features, or a dynamic scan's model at a time.
struct SegmentedModel {
  std::shared_ptr<const GaussianField> field;   // unused for a dynamic scan
  std::shared_ptr<const FeatureModel> features; // null: none
  std::shared_ptr<const DynamicField> dynamic;  // null: it does not move
  double time = 0;                              // s
  bool operator==(const SegmentedModel&) const = default;
};

/// Learns features for the model's Gaussians; for a dynamic scan, from the teacher at the model's time.
/// Throws as trainFrom() does.
FeatureModel trainFrom(const SegmentedModel& model, const Teacher& teacher,
                       const FeatureTraining& training = {});

} // namespace innergs
