#pragma once
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Prediction/SlicePredictor.h"

namespace innergs {

/// The shares (convex) of interpolation, of a field fitted to the slices and of what was learned from them.
/// errors: covariance when every second slice is withheld, i.e. at twice the slice distance. exists: which of
/// the three there are. rise: factors by which their errors grow relative to interpolation's at the distance
/// itself.
std::array<double, 3> predictionShares(Covariance<3> errors, const std::array<bool, 3>& exists,
                                       const std::array<double, 3>& rise);

/// How much what was learned loses of its gain over linear interpolation between twice the slice distance and
/// the distance itself, beyond what is usual: a factor of its error, 1 or more. twice, once: of its simulated
/// pairs.
double learnedRise(const PairErrors& twice, const PairErrors& once);

} // namespace innergs
