#include "Text/SegmentedModel.h"

#include "Core/Motion/DynamicFeatures.h"

namespace innergs {

FeatureModel trainFrom(const SegmentedModel& model, const Teacher& teacher, const FeatureTraining& training) {
  if (!model.dynamic) return trainFrom(*model.field, teacher, training);
  FeatureModel features = trainFrom(featureFieldAt(*model.dynamic, model.time), teacher, training);
  features.time = model.time;
  return features;
}

} // namespace innergs
