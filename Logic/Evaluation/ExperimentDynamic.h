#pragma once
#include "Core/Motion/DynamicJob.h"
#include "Evaluation/ExperimentTable.h"
#include "Evaluation/Protocols.h"

namespace innergs {

/// Interpolation in time of a moving scan: some frames withheld from every method, and judged on them alone.
struct DynamicExperiment {
  TimeSeries series;
  std::string name; // for titles
  std::int64_t every =
      8; // the paper's: frames 8, 16, … are withheld (the first is kept, as for the previous frame)
  DynamicSettings settings; // threads, seed, instruction set
  ProgressCallback progress;
  std::function<void(const std::string&)> say;
  std::stop_token stop;
};

struct DynamicExperimentResult {
  ExperimentTable methods; // pooled over all withheld frames
  ExperimentTable frames;  // one by one
};

/// Both kinds of Gaussians, the one that the program chooses, and what else is put between frames. Throws
/// Error(InvalidArgument) when no frame can be withheld, Error(Cancelled).
DynamicExperimentResult runDynamic(const DynamicExperiment& experiment);

/// The Gaussians of these settings ("gaussians") beside linear interpolation in time ("linear") and the
/// previous frame ("previous"), pooled over the withheld frames. Throws as runDynamic().
EvaluationReport judgeFrames(const DynamicExperiment& experiment);

} // namespace innergs
