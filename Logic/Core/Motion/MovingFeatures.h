#pragma once
#include "Core/Features/FeatureQuery.h"
#include "Core/Motion/DynamicField.h"

namespace innergs {

/// A moving model at a time (s) as features of its Gaussians see it: the Gaussians where they are then, with
/// their canonical intensities, as a contrast agent makes no other class of a tissue.
GaussianField featureFieldAt(const DynamicField& field, double time);

/// Options to query featureFieldAt() with features that were learned from labels of another time (s): the
/// classes' support and residual follow the tissue, see motionField(). Refers to `field`.
FeatureQueryOptions queryAt(const DynamicField& field, double time, double learned,
                            FeatureQueryOptions options = {});

} // namespace innergs
