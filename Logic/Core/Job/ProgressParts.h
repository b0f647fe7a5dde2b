#pragma once
#include "Core/Job/Progress.h"

#include <cstddef>
#include <vector>

namespace innergs {

/// Combines the progress of parts that run one after the other (a fit, then the one that judges it) into
/// that of one job.
class ProgressParts {
public:
  /// weights: expected cost of each part, in any unit; measured costs then correct the remaining time.
  ProgressParts(ProgressCallback callback, std::vector<double> weights);

  /// Starts the next part and returns the callback for its progress. From the second part on, the phase is
  /// the given one and everything but the iterations keeps the first part's values. Valid as long as this
  /// object.
  ProgressCallback next(Phase phase = Phase::Judging);
  /// Reports Done.
  void finish();

private:
  void report(const Progress& part);

  ProgressCallback callback_;
  std::vector<double> weights_;
  Phase phase_ = Phase::Judging; // of the current part, from the second on
  std::size_t current_ = 0, begun_ = 0;
  double weightBefore_ = 0, elapsedBefore_ = 0; // of the finished parts
  Progress first_, last_;                       // at the end of the first part; last reported
};

} // namespace innergs
