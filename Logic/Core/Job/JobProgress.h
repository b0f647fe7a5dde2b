#pragma once
#include "Core/Job/Progress.h"
#include "Core/Settings/Settings.h"

#include <chrono>

namespace innergs {

/// Progress after the search for the motion of slices, if any.
constexpr double motionEnds(Preset preset) {
  return preset == Preset::Fast ? 0.4 : 0.2;
}
constexpr double kFitStarts = 0.03; // without motion and prediction
// Where steps end, as shares of the progress from the start of the fit: the fit and the choice of a share,
// where predictions from several scans follow; otherwise the fit; the residual grid.
constexpr double kEachFitEnds = 0.6, kShareChosen = 0.75, kFitEnds = 0.92, kResidualEnds = 0.97;

/// A share of a job that is done, and the seconds since its start.
struct JobTime {
  double fraction = 0, elapsed = 0;
};
/// Seconds that remain at the pace since an earlier time; 0 (unknown) while little is done since.
double remainingSeconds(const JobTime& since, const JobTime& now);

/// Reports the progress of one fit, from its input to its volume.
class JobProgress {
public:
  explicit JobProgress(ProgressCallback callback) : callback_(std::move(callback)) {}

  /// fraction: of the fit; never falls below earlier values.
  void report(Phase phase, double fraction);
  /// Reports a sentence in the current phase.
  void say(const std::string& sentence);
  double elapsed() const; // seconds
  /// The remaining time follows from the pace from now on: what comes takes a different time.
  void changePace() { since_ = {state.fraction, elapsed()}; }

  Progress state; // sent with the next report()

private:
  ProgressCallback callback_;
  JobTime since_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace innergs
