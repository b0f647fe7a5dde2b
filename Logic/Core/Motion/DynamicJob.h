#pragma once
#include "Core/Device/Devices.h"
#include "Core/Job/Progress.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/Refinement.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Settings/Settings.h"

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

namespace innergs {

/// A fit that was stopped while all frames were refined together, or at the end of that.
struct StoppedDynamicFit {
  DynamicField field;
  RefinementState state;
  bool knowsSegments = false; // of Gaussians that resuming changes: a note says that the segments are gone
};

struct DynamicResult {
  std::shared_ptr<const DynamicField> field; // null: stopped before there was one
  bool cancelled = false;                    // true: state at the stop
  RefinementState state; // where the refinement was stopped, to go on from, or ended; empty: there was none
  int steps = 0;         // of the refinement, in all
  std::string choice;    // a sentence: why it is of its kind, on which frames it was judged
  std::vector<std::string> notes; // sentences for the user: what was asked for or found and not used
  Settings settings;              // with the kind that was chosen
  bool slicesTimed = false;       // slices counted at their own times (see acquiredFrame())
  double trainingPsnr = 0;        // dB over the range of the series, on the frames that were fitted
  double seconds = 0;
  DeviceUse device;
  std::string instructionSet;
  int threads = 0;
};

/// Bytes a job will need beyond its input.
std::int64_t estimateMemory(const TimeSeries& series, const Settings& settings);

/// Makes a continuous volume in space and time from a series. Of the settings it looks at those that
/// concernsMovingScans() names. Gaussians that move are fitted on the device chosen, as static ones are;
/// those that change their intensity on the CPU. Same series, settings, seed and device: the same bits at any
/// number of threads, stopped and resumed or not.
class DynamicJob {
public:
  DynamicJob(TimeSeries series, Settings settings);

  /// Continues a fit of the same series and settings; run() throws Error(InvalidArgument) if it is of others.
  void resume(std::shared_ptr<const StoppedDynamicFit> fit) { resumed_ = std::move(fit); }
  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }
  /// The field so far, from time to time while all frames are refined together; on the worker's thread.
  void onPreview(std::function<void(std::shared_ptr<const DynamicField>)> callback) {
    preview_ = std::move(callback);
  }

  /// Blocks. A stop request ends it within 200 ms with cancelled = true; stopped in the refinement, it has
  /// the field reached. Throws Error for what is wrong with series and settings, before any work.
  DynamicResult run(std::stop_token stop = {});

  const TimeSeries& series() const { return series_; }

private:
  void report(Phase phase, double fraction, double mse = -1);
  void show(const DynamicField& field);
  void considerDevice();
  void leaveDevice();

  TimeSeries series_;
  Settings settings_;
  std::shared_ptr<const StoppedDynamicFit> resumed_;
  ProgressCallback progress_;
  std::function<void(std::shared_ptr<const DynamicField>)> preview_;
  Progress state_;
  std::optional<DeviceChoice> device_;
  std::string told_;                   // the device that the user knows of
  double start_ = 0, nextPreview_ = 0; // s
};

} // namespace innergs
