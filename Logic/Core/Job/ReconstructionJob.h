#pragma once
#include "Core/Alignment/BiasCorrection.h"
#include "Core/Alignment/SliceMotion.h"
#include "Core/Alignment/StackAgreement.h"
#include "Core/Device/Devices.h"
#include "Core/Fit/Densify.h"
#include "Core/Image/Stack.h"
#include "Core/Job/Progress.h"
#include "Core/Job/ShownProfiles.h"
#include "Core/Model/Model.h"
#include "Core/Settings/Settings.h"
#include "Core/Uncertainty/Uncertainty.h"

#include <memory>
#include <stop_token>

namespace innergs {

/// Divides a scan by its smooth shading, found in its observed voxels; masked: those inside a mask.
/// Returns a sentence for the user. Throws Error.
using ShadingCorrection = std::function<std::string(Stack&, bool masked, const std::stop_token&)>;

/// The parts of a prediction besides interpolation. All are used, except to measure what one contributes.
struct PredictionParts {
  bool field = true, learned = true; // the candidates
  bool startWeights = true;          // false: networks start from random weights
};

/// The input of a reconstruction. The job keeps this snapshot; it does not change while the job runs.
struct ReconstructionInput {
  std::vector<Stack> stacks;
  /// None, one for all stacks or one per stack, each where its stack was scanned: only voxels inside are
  /// fitted; the model has values only there and up to one slice distance around.
  std::vector<Mask> masks;
  std::optional<GridGeometry> outputGrid; // default: isotropic at the finest spacing over the first stack's
                                          // box, cropped to the mask's
  bool cropToMask = false;                // also crop a given output grid to the mask's box
  /// Above 0, up to 0.5: the share of every stack's slices held out from a second fit with the same settings,
  /// which judges the quality on them. The delivered model is fitted to all slices.
  double heldOutFraction = 0;
  /// Also estimates how far the volume may be from the truth, by that second fit; without a fraction, one
  /// slice in five is held out.
  bool uncertainty = false;
  std::shared_ptr<const Model> resume; // continues from here
  ShadingCorrection n4;                // IO/N4Correction.h; without it, the setting `n4` is refused
  PredictionParts predictionParts;
};

struct ReconstructionResult {
  std::shared_ptr<const Model> model;
  Volume volume;           // on the output grid, scanner units
  bool cancelled = false;  // true: the state when stopped; volume only if requested
  double trainingPsnr = 0; // dB, fitted samples
  // From a second fit, on slices that it did not see; the model above saw them.
  Judging judging = Judging::NotAsked;
  double heldOutPsnr = std::numeric_limits<double>::quiet_NaN(); // dB, pooled; NaN: unknown
  std::int64_t heldOutSlices = 0;                                // scored, over all stacks
  double judgingSeconds = 0;
  std::optional<Uncertainty> uncertainty; // on the volume's grid, where asked for and found
  BiasCorrection bias;                    // of several stacks, likewise
  std::vector<StackAlignment> alignment;  // of several stacks, where the settings ask for it
  std::vector<StackAgreement> agreement;  // of several stacks, whatever the settings
  SliceMotion sliceMotion;                // beyond that, likewise; empty: not looked for
  std::string prediction;                 // a sentence: what fills the gaps between slices; empty: nothing
  ShownProfiles profiles;                 // how thick the slices look
  double predictionShare = 0;             // of several scans: the weight of predictions from each alone
  double noise = 0;                       // estimated, scanner units
  std::int64_t nonFiniteVoxels = 0;       // left out of the fit
  int iterations = 0;                     // of the model, those of earlier runs included
  int iterationsRun = 0;                  // of them in this run
  DensifyCounts densified;                // by this run, all members
  double seconds = 0;                     // everything
  double fitSeconds = 0;                  // iterations of this model alone; 0: stopped before the first
  Settings settings;                      // with every optional filled in
  DeviceUse device;                       // where the fit ended
  std::string instructionSet;             // what ran on the CPU
  int threads = 0;                        // that ran there; 0: stopped before the first
  std::vector<std::string> warnings;      // sentences for the user
};

/// Where a slice was found to lie: its scan's alignment, then its own motion; rigid, LPS mm, applied to where
/// the scan's header puts it.
Affine3 slicePlace(const ReconstructionResult& result, std::size_t scan, std::size_t slice);

/// Runs one reconstruction. run() reports all errors in input and settings before any work.
class ReconstructionJob {
public:
  ReconstructionJob(ReconstructionInput input, Settings settings);
  ~ReconstructionJob();
  ReconstructionJob(const ReconstructionJob&) = delete;
  ReconstructionJob& operator=(const ReconstructionJob&) = delete;

  void onProgress(ProgressCallback callback);
  /// A rendering of the output grid at reduced size, a few times during the fit.
  void onPreview(std::function<void(const Volume&)> callback);

  /// Blocks. A stop request ends it within 200 ms with cancelled = true and the model fitted so far; during
  /// the judging it ends only that. Throws Error. renderWhenCancelled: also renders the volume of
  /// a stopped fit.
  ReconstructionResult run(std::stop_token stop = {}, bool renderWhenCancelled = false);

  /// Returns its input; the job cannot run again.
  ReconstructionInput takeInput();

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

} // namespace innergs
