#pragma once
#include "Core/Motion/DynamicJob.h"
#include "Evaluation/ExperimentTable.h"
#include "Evaluation/Protocols.h"

namespace innergs {

/// Interpolates a dynamic scan in time: holds out some frames from every method and scores on these only.
struct DynamicExperiment {
  TimeSeries series;
  std::string name; // for titles
  std::int64_t every =
      8; // the paper's: holds out frames 8, 16, … (keeps the first, which previous-frame needs)
  Settings settings;
  ProgressCallback progress;
  std::function<void(const std::string&)> say;
  std::stop_token stop;
};

struct DynamicExperimentResult {
  ExperimentTable methods; // pooled over all held-out frames
  ExperimentTable frames;  // a row per method and frame
};

/// Compares all kinds of Gaussians, the one that the program chooses, and other interpolations between
/// frames. Throws Error(InvalidArgument) if no frame can be held out, Error(Cancelled).
DynamicExperimentResult runDynamic(const DynamicExperiment& experiment);

/// Scores the Gaussians of these settings ("gaussians"), linear interpolation in time ("linear") and the
/// previous frame ("previous"), pooled over the held-out frames. Throws as runDynamic().
EvaluationReport judgeFrames(const DynamicExperiment& experiment);

} // namespace innergs
