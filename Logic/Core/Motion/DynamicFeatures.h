#pragma once
#include "Core/Features/FeatureQuery.h"
#include "Core/Motion/DynamicField.h"

namespace innergs {

/// A dynamic model at a time (s) as its features see it: the Gaussians where they are then, but with their
/// canonical intensities, as a contrast agent does not change a tissue's class.
GaussianField featureFieldAt(const DynamicField& field, double time);

/// Options to query featureFieldAt() with features that were learned from labels of another time (s): the
/// classes' support and residual follow the tissue, see motionField(). Refers to `field`.
FeatureQueryOptions queryAt(const DynamicField& field, double time, double learned,
                            FeatureQueryOptions options = {});

} // namespace innergs
