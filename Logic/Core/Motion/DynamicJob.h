#pragma once
#include "Core/Job/Progress.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/TimeSeries.h"

#include <memory>
#include <stop_token>

namespace innergs {

/// What can be chosen for a continuous volume in space and time.
struct DynamicSettings {
  std::optional<DynamicKind> kind; // unset: motion or intensity, whichever foresees withheld frames better
  std::optional<std::int64_t>
      gaussians;   // unset: from the data (a sixth of the voxels; where they change alone, one each)
  int threads = 0; // 0: all cores
  std::string instructionSet; // "": best available
  std::uint64_t seed = 1;
};

struct DynamicResult {
  std::shared_ptr<const DynamicField> field; // null: stopped before there was one
  bool cancelled = false;                    // true: state at the stop
  std::string choice;      // a sentence: why it is of its kind, on which frames it was judged
  double trainingPsnr = 0; // dB over the range of the series, on the frames that were fitted
  double seconds = 0;
  std::string instructionSet;
  int threads = 0;
};

/// Bytes a job will need beyond its input.
std::int64_t estimateMemory(const TimeSeries& series, const DynamicSettings& settings);

/// Makes a continuous volume in space and time from a series, on the CPU. Same series, settings and seed: the
/// same bits at any number of threads.
class DynamicJob {
public:
  DynamicJob(TimeSeries series, DynamicSettings settings);

  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }

  /// Blocks. A stop request ends it within 200 ms with cancelled = true; stopped in the refinement, it has
  /// the field reached. Throws Error for what is wrong with series and settings, before any work.
  DynamicResult run(std::stop_token stop = {});

  const TimeSeries& series() const { return series_; }

private:
  void report(Phase phase, double fraction, double mse = -1);

  TimeSeries series_;
  DynamicSettings settings_;
  ProgressCallback progress_;
  Progress state_;
  double start_ = 0; // s
};

} // namespace innergs
