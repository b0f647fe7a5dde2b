#pragma once
#include "Core/Features/FeatureQuery.h"

namespace innergs {

/// What features without a residual miss of the labelled slices of a labelmap of classes. Throws
/// Error(Cancelled).
ClassResidual residualOf(const GaussianField& field, const FeatureModel& features, const Labelmap& classes,
                         const FeatureQueryOptions& options);

} // namespace innergs
