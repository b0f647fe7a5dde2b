#include "Core/Job/Progress.h"

namespace innergs {

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing:
    return "Preparing";
  case Phase::Aligning:
    return "Aligning scans and slices";
  case Phase::Predicting:
    return "Predicting between slices";
  case Phase::Initialising:
    return "Placing Gaussians";
  case Phase::Tracking:
    return "Tracking frames";
  case Phase::Fitting:
    return "Fitting";
  case Phase::Refining:
    return "Refining";
  case Phase::Rendering:
    return "Rendering";
  case Phase::Judging:
    return "Judging the quality (second fit)";
  case Phase::Estimating:
    return "Estimating the uncertainty";
  case Phase::Done:
    return "Done";
  }
  return "";
}

} // namespace innergs
