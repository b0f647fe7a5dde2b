#pragma once
#include "Core/Job/Progress.h"

#include <cstddef>
#include <vector>

namespace innergs {

/// The progress of parts that run one after the other (a fit, then the judging of its quality) as that of one
/// job.
class ProgressParts {
public:
  /// weights: what each part is expected to cost, in any unit; their measured cost corrects the remaining
  /// time as they go.
  ProgressParts(ProgressCallback callback, std::vector<double> weights);

  /// Begins the next part; the callback is for its own progress. From the second part on the phase is Judging
  /// and all but the iterations stays as the first part left it. Valid as long as this object.
  ProgressCallback next();
  /// Reports Done.
  void finish();

private:
  void report(const Progress& part);

  ProgressCallback callback_;
  std::vector<double> weights_;
  std::size_t current_ = 0, begun_ = 0;
  double weightBefore_ = 0, elapsedBefore_ = 0; // of the parts that are over
  Progress first_, last_;                       // as the first part ended; as last reported
};

} // namespace innergs
