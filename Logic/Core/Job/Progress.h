#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace innergs {

enum class Phase {
  Preparing,
  Aligning,   // several scans, and the slices of each
  Predicting, // what lies between the slices of each scan
  Initialising,
  Tracking, // fits a dynamic scan frame by frame
  Fitting,
  Refining,
  Rendering,
  Judging,    // judges the quality by a second fit, whose steps have no phases of their own
  Estimating, // how far the result may be off, likewise by other fits
  Done
};
const char* phaseName(Phase phase);

/// From then on, a stop ends only the measurements of the result.
inline bool resultIsComplete(Phase phase) {
  return phase == Phase::Judging || phase == Phase::Estimating;
}

/// How judging the quality by a second fit ended; the result is complete in any case.
enum class Judging { NotAsked, Done, Stopped, Failed };

/// A job's state, passed to its progress callback on the worker thread.
struct Progress {
  Phase phase = Phase::Preparing;
  double fraction = 0;      // of the whole job, 0…1, never decreases
  int iteration = 0;        // iterations over the data so far; from Judging on those of the other fits
  int iterations = 0;       // planned iterations, likewise
  int members = 1;          // ensemble members, fitted one after the other: iterations / members each
  int coarseIterations = 0; // the first iterations of each member, at half resolution
  // Of the delivered model, also from Judging on.
  double loss = 0; // of the last iteration, normalised intensity units
  double trainingPsnr = std::numeric_limits<double>::quiet_NaN(); // dB on the fitted samples; NaN: unknown so
                                                                  // far
  double heldOutPsnr = std::numeric_limits<double>::quiet_NaN(); // dB, see ReconstructionResult; NaN: unknown
  std::int64_t gaussians = 0;
  double elapsed = 0;   // seconds
  double remaining = 0; // seconds, estimated
  std::string note;     // a sentence for the user, sent once: where the fit runs and why
};
using ProgressCallback = std::function<void(const Progress&)>;

} // namespace innergs
