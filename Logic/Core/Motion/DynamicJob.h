#pragma once
#include "Core/Device/Devices.h"
#include "Core/Job/Progress.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Motion/RefinementState.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Settings/Settings.h"

#include <memory>
#include <optional>
#include <stop_token>
#include <string>

namespace innergs {

/// A fit that was stopped during the joint refinement of all frames, or had completed it.
struct StoppedDynamicFit {
  DynamicField field;
  RefinementState state;
  bool knowsSegments = false; // lost on resuming, as their Gaussians change; a note says so
};

struct DynamicResult {
  std::shared_ptr<const DynamicField> field; // null: stopped before there was one
  bool cancelled = false;                    // true: state at the stop
  RefinementState state;          // of the refinement when it was stopped or ended; empty: there was none
  int steps = 0;                  // of the refinement, in all
  std::string choice;             // a sentence: why this kind was chosen, judged on which frames
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

/// Makes a continuous volume in space and time from a series. Uses only the settings that
/// concernsDynamicScans() names. Moving Gaussians are fitted on the chosen device, as static ones are;
/// changing intensities, on the CPU. With the same series, settings, seed and device, bit-identical at any
/// number of threads, stopped and resumed or not.
class DynamicJob {
public:
  DynamicJob(TimeSeries series, Settings settings);

  /// Continues a fit of the same series and settings; run() throws Error(InvalidArgument) if it is not one.
  void resume(std::shared_ptr<const StoppedDynamicFit> fit) { resumed_ = std::move(fit); }
  void onProgress(ProgressCallback callback) { progress_ = std::move(callback); }
  /// Called with the field so far, now and then during the joint refinement, on the worker's thread.
  void onPreview(std::function<void(std::shared_ptr<const DynamicField>)> callback) {
    preview_ = std::move(callback);
  }

  /// Blocks. A stop request ends it within 200 ms with cancelled = true; if stopped in the refinement, the
  /// result has the field so far. Throws Error for an invalid series or settings before any work.
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
  std::string reportedDevice_;         // its id, "" at first
  double start_ = 0, nextPreview_ = 0; // s
};

} // namespace innergs
