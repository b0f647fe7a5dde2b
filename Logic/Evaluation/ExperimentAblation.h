#pragma once
#include "Evaluation/ExperimentFits.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// One choice varied, the others left: what it is worth.
struct Ablation {
  struct Row {
    std::string label;
    const FitOutcome* fit; // owned by the fits
  };
  std::string name;  // "blending", "initialisation", ...
  std::string title; // for the chart
  std::vector<Row> rows;
  ExperimentTable table;
};

/// Names of all ablations in their order.
std::vector<std::string> ablationNames();
/// Throws Error(InvalidArgument) for another name.
Ablation runAblation(ExperimentFits& fits, const std::string& name);

/// Every report of every fit: iteration, seconds and training PSNR, and at its end the PSNR on the withheld
/// slices.
ExperimentTable curvesOf(const Ablation& ablation);

} // namespace innergs
