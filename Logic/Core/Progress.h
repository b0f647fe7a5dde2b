#pragma once
#include <cstdint>
#include <functional>
#include <string>

namespace innergs {

enum class Phase { Preparing, Initialising, Fitting, Refining, Rendering, Done };
const char* phaseName(Phase phase);

/// A job's state, given to its progress callback on the worker thread.
struct Progress {
  Phase phase = Phase::Preparing;
  double fraction = 0;     // of the whole job, 0…1, never decreases
  int iteration = 0;       // sweeps over the data so far
  int iterations = 0;      // sweeps planned
  double loss = 0;         // of the last sweep, normalised intensity units
  double trainingPsnr = 0; // dB on the fitted samples (not held out)
  double heldOutPsnr = 0;  // dB on held-out samples; NaN when none are held out
  std::int64_t gaussians = 0;
  double elapsed = 0;   // seconds
  double remaining = 0; // seconds, estimated
  std::string note;     // a sentence for the user, in one report only: where the fit runs and why
};
using ProgressCallback = std::function<void(const Progress&)>;

} // namespace innergs
