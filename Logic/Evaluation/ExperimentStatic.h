#pragma once
#include "Evaluation/ExperimentFits.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// Static reconstruction: every blending by protocol P per plane and by protocol H, beside the paper's row.
struct StaticExperiment {
  struct Row {
    std::string label;
    const FitOutcome *paper, *heldOut; // owned by the fits
  };
  std::vector<Row> rows;
  ExperimentTable perPlane, held; // protocol P, protocol H
  Volume truth;                   // protocol P's lattice, axial slices along K
  std::int64_t slice = 0;         // a withheld axial slice of it, the one nearest the middle
  double peak = 0;                // image units
};

StaticExperiment runStatic(ExperimentFits& fits);

} // namespace innergs
