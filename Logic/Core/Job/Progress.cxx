#include "Core/Job/Progress.h"

#include "Core/Base/Translation.h"

namespace innergs {

const char* phaseName(Phase phase) {
  switch (phase) {
  case Phase::Preparing:
    return tr("Preparing");
  case Phase::Aligning:
    return tr("Aligning scans and slices");
  case Phase::Predicting:
    return tr("Predicting between slices");
  case Phase::Initialising:
    return tr("Placing Gaussians");
  case Phase::Tracking:
    return tr("Tracking frames");
  case Phase::Fitting:
    return tr("Fitting");
  case Phase::Refining:
    return tr("Refining");
  case Phase::Rendering:
    return tr("Rendering");
  case Phase::Judging:
    return tr("Judging the quality (second fit)");
  case Phase::Estimating:
    return tr("Estimating the uncertainty");
  case Phase::Done:
    return tr("Done");
  }
  return "";
}

} // namespace innergs
