#pragma once
#include "Core/Alignment/SliceMotion.h"
#include "Core/Alignment/StackAlignment.h"
#include "Core/Device/Devices.h"
#include "Core/Fit/Densify.h"
#include "Core/Image/Stack.h"
#include "Core/Job/Progress.h"
#include "Core/Model/Model.h"
#include "Core/Settings/Settings.h"

#include <memory>
#include <stop_token>

namespace innergs {

/// What a reconstruction works on. The job keeps this snapshot; nothing in it changes while it runs.
struct ReconstructionInput {
  std::vector<Stack> stacks;
  std::optional<Mask> mask; // patient-space mask: only voxels inside are fitted, and the model has values
                            // there and within a slice distance alone
  std::optional<GridGeometry>
      outputGrid; // default: isotropic at the finest spacing over the first stack's box, cut to the mask's
  bool cropToMask = false; // cut a given output grid to the mask's box as well
  /// Above 0, up to 0.5: of every stack's slices, to be withheld from a second fit with the same settings
  /// that judges the quality on them. What is delivered is fitted to all slices.
  double heldOutFraction = 0;
  std::shared_ptr<const Model> resume; // go on from here
};

struct ReconstructionResult {
  std::shared_ptr<const Model> model;
  Volume volume;           // on the output grid, scanner units
  bool cancelled = false;  // true: state at the stop, volume rendered only if asked for
  double trainingPsnr = 0; // dB, fitted samples
  // Of a second fit, on slices that it did not see; the model above saw them.
  Judging judging = Judging::NotAsked;
  double heldOutPsnr = std::numeric_limits<double>::quiet_NaN(); // dB, pooled; NaN: unknown
  std::int64_t heldOutSlices = 0;                                // that were scored, over all stacks
  double judgingSeconds = 0;
  std::vector<StackAlignment> alignment; // of several stacks, where the settings ask for it
  SliceMotion sliceMotion;               // beyond that, likewise; empty: not looked for
  std::string prediction;            // a sentence: what was put between the slices; empty: nothing
  double noise = 0;                  // estimated, scanner units
  std::int64_t nonFiniteVoxels = 0;  // left out of the fit
  int iterations = 0;                // of the model, those of earlier runs included
  int iterationsRun = 0;             // of them in this run
  DensifyCounts densified;           // by this run, all members
  double seconds = 0;                // everything
  double fitSeconds = 0;             // iterations of this model alone; 0: stopped before the first
  Settings settings;                 // with every optional filled in
  DeviceUse device;                  // where the fit ended
  std::string instructionSet;        // what ran on the CPU
  int threads = 0;                   // that ran there; 0: stopped before the first
  std::vector<std::string> warnings; // sentences for the user
};

/// Bytes a job will need beyond its input, its second fit included.
std::int64_t estimateMemory(const ReconstructionInput& input, const Settings& settings);

/// Runs one reconstruction. Everything that can be wrong with input and settings is thrown by run() before
/// any work.
class ReconstructionJob {
public:
  ReconstructionJob(ReconstructionInput input, Settings settings);
  ~ReconstructionJob();
  ReconstructionJob(const ReconstructionJob&) = delete;
  ReconstructionJob& operator=(const ReconstructionJob&) = delete;

  void onProgress(ProgressCallback callback);
  /// A rendering of the output grid's lattice at reduced size, a few times during the fit.
  void onPreview(std::function<void(const Volume&)> callback);

  /// Blocks. A stop request ends it within 200 ms with cancelled = true and the model reached; while the
  /// quality is judged it only ends that. Throws Error. renderWhenCancelled: also render the volume of a
  /// stopped fit.
  ReconstructionResult run(std::stop_token stop = {}, bool renderWhenCancelled = false);

  /// What it worked on, given away: it cannot run again.
  ReconstructionInput takeInput();

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace innergs
