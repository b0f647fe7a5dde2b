#pragma once
#include "Core/Job/ResidualRefinement.h"
#include "Core/Job/SlicePrediction.h"

namespace innergs {

/// What lies between the slices of one scan, or of several that mostly lie beside each other.
struct PredictedScans {
  Stack thin;                             // thin slices, observed where the field will have values
  double kept = 1;                        // share of its grid in the box of the masks
  double noise = 0;                       // of the scans, without what their slices share; scanner units
  std::optional<WeightedVolume> averaged; // fields fitted to noisy slices alone, to average with it
  std::string sentence;                   // says what was put between the slices
};

/// Of several scans, each is predicted on its own, with the nearest slices of parallel ones. Reports
/// progress up to the start of the fit to the prediction. Throws Error(Cancelled).
PredictedScans predictScans(const PreparedInput& prepared, const Settings& settings,
                            const PredictionParts& parts, const IntensityMap& map,
                            const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                            ThreadPool& pool);

} // namespace innergs
