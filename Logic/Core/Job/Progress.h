#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <string>

namespace innergs {

enum class Phase {
  Preparing,
  Aligning,   // several scans, and the slices of each
  Predicting, // what lies between the slices of one scan
  Initialising,
  Tracking, // a moving scan's frames, one after the other
  Fitting,
  Refining,
  Rendering,
  Judging, // the quality, by a second fit: its steps have no phases of their own
  Done
};
const char* phaseName(Phase phase);

/// How the judging of a result's quality by a second fit ended; the result is complete in any case.
enum class Judging { NotAsked, Done, Stopped, Failed };

/// A job's state, given to its progress callback on the worker thread.
struct Progress {
  Phase phase = Phase::Preparing;
  double fraction = 0;      // of the whole job, 0…1, never decreases
  int iteration = 0;        // iterations over the data so far; while Judging those of the second fit
  int iterations = 0;       // iterations planned, likewise
  int members = 1;          // of the ensemble, fitted one after the other: iterations / members each
  int coarseIterations = 0; // the first iterations of each member, which see the data at half resolution
  // Of the model that is delivered, also while Judging.
  double loss = 0; // of the last iteration, normalised intensity units
  double trainingPsnr =
      std::numeric_limits<double>::quiet_NaN();                  // dB on the fitted samples; NaN: unknown yet
  double heldOutPsnr = std::numeric_limits<double>::quiet_NaN(); // dB, see ReconstructionResult; NaN: unknown
  std::int64_t gaussians = 0;
  double elapsed = 0;   // seconds
  double remaining = 0; // seconds, estimated
  std::string note;     // a sentence for the user, in one report only: where the fit runs and why
};
using ProgressCallback = std::function<void(const Progress&)>;

} // namespace innergs
