#pragma once
#include "Core/Job/ReconstructionJob.h"

#include <chrono>
#include <map>
#include <mutex>

namespace innergs {

/// Rough estimate of the seconds that a job including its second fit and its uncertainty takes: often within
/// a factor of two if nothing else runs, an upper bound if a stop rule may end the fit. On the CPU it times a
/// similar job on a few thousand voxels, which takes some tens of milliseconds at the first call for given
/// settings and spacings. On another device it uses the last fit there; before the first one the time is
/// unknown: 0. As for the memory, the grids of the stacks and of the output suffice; if a mask's voxels
/// are given, their number counts. Throws Error for settings and grids that the job would refuse.
double estimateSeconds(const ReconstructionInput& input, const Settings& settings);

/// Records the duration of a completed fit on a device other than the CPU, for later estimates.
void rememberSpeed(const ReconstructionInput& input, const ReconstructionResult& result);

/// Seconds spent on the parts of a small fit.
struct TrialTimes {
  double start = 0;            // before the first iteration
  double coarse = 0, fine = 0; // per iteration
  double refine = 0, render = 0;
  double total = 0;
};

/// Implements estimateSeconds(): times small fits and remembers the results.
class TimeEstimator {
public:
  /// Runs a fit of a few iterations, the first ones coarse.
  using Trial = std::function<TrialTimes(ReconstructionInput small, const Settings& settings, int coarse)>;

  /// Seconds per multiply-add of a network, in one thread.
  using MultiplyTime = std::function<double(const std::string& instructionSet)>;

  TimeEstimator(Trial trial, MultiplyTime multiplyTime)
      : trial_(std::move(trial)), multiplyTime_(std::move(multiplyTime)) {}

  double seconds(const ReconstructionInput& input, const Settings& settings);
  void remember(const ReconstructionInput& input, const ReconstructionResult& result);

private:
  struct Timing {
    TrialTimes times;
    double voxels = 0, outputVoxels = 0; // of the small fit
    std::chrono::steady_clock::time_point when;
    bool disturbed = false; // another job ran in this process
  };
  struct Speed {
    double pass = 0; // over all data: seconds per voxel
    double rest = 0; // seconds per voxel read or written
  };
  Timing timed(const ReconstructionInput& input, const Settings& filled, const GridGeometry& output,
               double voxels) const;
  Timing timingOf(const ReconstructionInput& input, const Settings& filled, const GridGeometry& output);
  /// Without the simulation of the uncertainty. choosing: with the trial that chooses the share of
  /// predictions from each of several scans.
  double fitSeconds(const ReconstructionInput& input, const Settings& settings, bool choosing);
  double predictedSeconds(const ReconstructionInput& input, const Settings& settings, const Settings& filled,
                          const GridGeometry& output);
  double fieldSeconds(const Stack& scan, const GridGeometry& grid, const Settings& settings);
  double scanSeconds(const Stack& scan, const GridGeometry& grid, const Settings& settings);
  double eachSeconds(std::span<const Stack> stacks, const Settings& settings);
  double learningSeconds(const Stack& scan, const GridGeometry& grid, const Settings& settings) const;

  Trial trial_;
  MultiplyTime multiplyTime_;
  std::mutex mutex_;
  std::map<std::string, Timing> timings_; // the fastest so far, by what they depend on
  std::map<std::string, Speed> speeds_;   // by device
};

} // namespace innergs
