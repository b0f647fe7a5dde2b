#pragma once
#include "Core/Job/Progress.h"

#include <chrono>

namespace innergs {

constexpr double kMotionEnds = 0.4;     // of slices, where it is looked for
constexpr double kPredictionEnds = 0.5;                                    // where there is one
constexpr double kFitStarts = 0.03, kFitEnds = 0.92, kResidualEnds = 0.97; // of the progress bar

/// The progress of one fit, from its input to its volume, as it is reported.
class JobProgress {
public:
  explicit JobProgress(ProgressCallback callback) : callback_(std::move(callback)) {}

  /// fraction: of the fit; lower ones than before are raised to it.
  void report(Phase phase, double fraction);
  /// A report in the present phase that says a sentence.
  void say(const std::string& sentence);
  double elapsed() const; // seconds

  Progress state; // reported with the next report()

private:
  ProgressCallback callback_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

} // namespace innergs
