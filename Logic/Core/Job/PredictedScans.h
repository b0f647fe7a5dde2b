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

/// What lies between the slices of one of several scans.
struct PredictedPart {
  Stack thin;
  std::optional<Volume> field; // fitted to the slices alone, see PartNoise
  std::string sentence;
  bool backProjects = false; // SlicePrediction::backProjects()
};

/// Of a scan; a field is kept where it is averaged with the prediction.
struct PartNoise {
  double deviation = 0; // standard deviation, scanner units
  bool keepsField = false;
};

/// Fractions of a job's progress.
struct ProgressRange {
  double from = 0, to = 1;
};

/// scan: one of `prepared`, maybe with slices of its neighbours. grid: its planes are among those predicted,
/// if parallel. Throws Error(Cancelled).
PredictedPart predictPart(const PreparedInput& prepared, Stack scan, const GridGeometry& grid,
                          const Settings& settings, const PredictionParts& parts, const PartNoise& noise,
                          const SlicePrediction::FieldFit& fitField, const ProgressRange& range,
                          JobProgress& progress, ThreadPool& pool);

/// Of several scans, each is predicted on its own, with the nearest slices of parallel ones. Reports
/// progress up to the start of the fit to the prediction. Throws Error(Cancelled).
PredictedScans predictScans(const PreparedInput& prepared, const Settings& settings,
                            const PredictionParts& parts, const IntensityMap& map,
                            const SlicePrediction::FieldFit& fitField, JobProgress& progress,
                            ThreadPool& pool);

} // namespace innergs
