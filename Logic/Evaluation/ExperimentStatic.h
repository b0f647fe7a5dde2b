#pragma once
#include "Evaluation/ExperimentFits.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// Static reconstruction: every blending under protocol P per plane and under protocol H, next to the paper's
/// row.
struct StaticExperiment {
  struct Row {
    std::string label;
    const FitOutcome *paper, *heldOut; // owned by the fits
  };
  std::vector<Row> rows;
  ExperimentTable perPlane, held; // protocol P, protocol H
  Volume truth;                   // protocol P's grid, axial slices along K
  std::int64_t slice = 0;         // a held-out axial slice, the nearest to the middle
  double peak = 0;                // image units
};

StaticExperiment runStatic(ExperimentFits& fits);

} // namespace innergs
