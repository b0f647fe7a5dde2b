#include "Core/Motion/DynamicFeatures.h"

#include "Core/Motion/MotionField.h"

namespace innergs {

GaussianField featureFieldAt(const DynamicField& field, double time) {
  GaussianField out = fieldAt(field, time);
  for (std::size_t g = 0; g < out.gaussians.size(); ++g)
    out.gaussians[g].intensity = field.canonical.gaussians[g].intensity;
  return out;
}

FeatureQueryOptions queryAt(const DynamicField& field, double time, double learned,
                            FeatureQueryOptions options) {
  if (field.kind != DynamicKind::Intensity && time != learned)
    options.displacement = [&field, time, learned, threads = options.threads,
                            stop = options.stop](const GridGeometry& geometry) {
      return motionField(field, time, learned, geometry, threads, stop);
    };
  return options;
}

} // namespace innergs
