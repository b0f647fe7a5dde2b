#pragma once
#include "Core/Prediction/ConvexShares.h"
#include "Core/Prediction/SlicePredictor.h"

namespace innergs {

/// The shares (convex) of interpolation, of a field fitted to the slices and of what was learned from them.
/// errors: covariance when every second slice is held out, i.e. at twice the slice distance. exists: which of
/// the three exist. rise: factors by which their errors grow relative to interpolation's at the distance
/// itself.
std::array<double, 3> predictionShares(Covariance<3> errors, const std::array<bool, 3>& exists,
                                       const std::array<double, 3>& rise);

/// By what factor the learned prediction's error, relative to linear interpolation's, grows from twice the
/// slice distance to the distance itself, beyond what is usual; at least 1. twice, once: on the simulated
/// pairs.
double learnedRise(const PairErrors& twice, const PairErrors& once);

} // namespace innergs
