#pragma once
#include "Evaluation/ExperimentFits.h"

namespace innergs {

/// What each part of the prediction between one scan's slices is worth: interpolations and parts alone, and
/// the whole with one of them left out, on slices that nothing saw.
struct PredictionAblation {
  struct Row {
    std::string label;
    std::string family;             // "interpolation", "part alone", "whole"
    std::optional<Quality> quality; // empty: it does not apply to this scan
    double seconds = 0, cpuSeconds = 0;
  };
  struct Case {
    std::string name;  // for file names
    std::string title; // "every 4th slice kept"
    std::vector<Row> rows;
  };
  std::vector<Case> cases;
  ExperimentTable table;
};

/// Protocol H with every 4th axial slice kept, and with axial slices four voxels thick; preset balanced (a
/// quick run: fast), which chooses the number of Gaussians.
PredictionAblation runPredictionAblation(const ExperimentSetup& setup);

} // namespace innergs
