#pragma once
#include "Core/Job/Progress.h"

#include <chrono>

namespace innergs {

constexpr double kMotionEnds = 0.4; // progress after the search for the motion of slices, if any
constexpr double kFitStarts = 0.03; // without motion and prediction
// Where steps end, as shares of the progress from the start of the fit: the fit and the choice of a share,
// where predictions from several scans follow; otherwise the fit; the residual grid.
constexpr double kEachFitEnds = 0.6, kShareChosen = 0.75, kFitEnds = 0.92, kResidualEnds = 0.97;

/// Reports the progress of one fit, from its input to its volume.
class JobProgress {
public:
  explicit JobProgress(ProgressCallback callback) : callback_(std::move(callback)) {}

  /// fraction: of the fit; never falls below earlier values.
  void report(Phase phase, double fraction);
  /// Reports a sentence in the current phase.
  void say(const std::string& sentence);
  double elapsed() const; // seconds

  Progress state; // sent with the next report()

private:
  ProgressCallback callback_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace innergs
