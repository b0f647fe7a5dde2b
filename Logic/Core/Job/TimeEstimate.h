#pragma once
#include "Core/Job/ReconstructionJob.h"

#include <chrono>
#include <map>
#include <mutex>

namespace innergs {

/// Seconds that a job will take with its second fit, roughly: often within a factor of two where nothing else
/// runs, an upper bound where a stop rule may end the fit. On the CPU a job of the same kind on a few
/// thousand voxels is timed for that, some tens of milliseconds at the first call for given settings and
/// spacings; on another device the last fit there counts, and before the first one the time is unknown: 0. As
/// for the memory, the lattices of the stacks and of the output are enough; of a mask's voxels, where they
/// are given, the number counts. Throws Error for settings and lattices that the job would refuse.
double estimateSeconds(const ReconstructionInput& input, const Settings& settings);

/// What a fit that ran to its end on another device than the CPU took, for estimates to come.
void rememberSpeed(const ReconstructionInput& input, const ReconstructionResult& result);

/// Seconds of the parts of a small fit.
struct TrialTimes {
  double start = 0;            // before the first iteration
  double coarse = 0, fine = 0; // of one iteration
  double refine = 0, render = 0;
  double total = 0;
};

/// What estimateSeconds() works with: the timing of small fits, remembered.
class TimeEstimator {
public:
  /// Runs a fit of a few iterations, the first ones coarse.
  using Trial = std::function<TrialTimes(ReconstructionInput small, const Settings& settings, int coarse)>;

  explicit TimeEstimator(Trial trial) : trial_(std::move(trial)) {}

  double seconds(const ReconstructionInput& input, const Settings& settings);
  void remember(const ReconstructionInput& input, const ReconstructionResult& result);

private:
  struct Timing {
    TrialTimes times;
    double voxels = 0, outputVoxels = 0; // of the small fit
    std::chrono::steady_clock::time_point when;
    bool disturbed = false; // by another job of this process
  };
  struct Speed {
    double iteration = 0; // seconds per voxel
    double rest = 0;      // seconds per voxel read or written
  };
  Timing timed(const ReconstructionInput& input, const Settings& filled, const GridGeometry& output,
               double voxels) const;
  Timing timingOf(const ReconstructionInput& input, const Settings& filled, const GridGeometry& output);
  double predictedSeconds(const ReconstructionInput& input, const Settings& settings, const Settings& filled,
                          const GridGeometry& output);

  Trial trial_;
  std::mutex mutex_;
  std::map<std::string, Timing> timings_; // the quickest so far, by what they depend on
  std::map<std::string, Speed> speeds_;   // by device
};

} // namespace innergs
