#pragma once
#include "Evaluation/ExperimentFits.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// Varies one choice and keeps all others, to measure its effect.
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

/// Names of all ablations, in order.
std::vector<std::string> ablationNames();
/// Throws Error(InvalidArgument) for any other name.
Ablation runAblation(ExperimentFits& fits, const std::string& name);

/// Every progress report of every fit: iteration, seconds and training PSNR, and in the last one the PSNR on
/// the held-out slices.
ExperimentTable curvesOf(const Ablation& ablation);

} // namespace innergs
