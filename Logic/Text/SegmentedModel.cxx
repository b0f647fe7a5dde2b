#include "Text/SegmentedModel.h"

#include "Core/Motion/MovingFeatures.h"

namespace innergs {

FeatureModel trainFrom(const SegmentedModel& model, const Teacher& teacher, const FeatureTraining& training) {
  if (!model.moving) return trainFrom(*model.field, teacher, training);
  FeatureModel features = trainFrom(featureFieldAt(*model.moving, model.time), teacher, training);
  features.time = model.time;
  return features;
}

} // namespace innergs
