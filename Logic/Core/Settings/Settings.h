#pragma once
#include "Core/Model/GaussianField.h"
#include "Core/Settings/DynamicKind.h"
#include "Core/Settings/LossKind.h"
#include "Core/Settings/Selection.h"

#include <optional>
#include <string>

namespace innergs {

enum class Preset {
  Fast,
  Balanced,
  Best,
  Paper // the paper's Algorithm 1
};
enum class Initialisation {
  Adaptive, // density follows the image structure
  Grid      // an even grid, as the paper's 42³
};
enum class Schedule {
  Exponential, // the learning rates decay exponentially to a fixed share
  Plateau      // the rates are reduced whenever the loss stops improving
};

/// What fills the gaps of a single scan with distant slices, before Gaussians are fitted to it.
enum class PredictionKind {
  Auto,          // the same as Learned
  None,          // nothing: the Gaussians bridge the gaps themselves
  Interpolation, // a mixture of classical interpolations, chosen by the scan's own slices
  Learned // what is learned from the scan's own in-plane detail; where that does not pay, Interpolation
};

/// Whether the slices of several scans, or packets of them, get rigid motions of their own.
enum class SliceMotionKind {
  Auto, // where the scans agree better with it
  On,
  Off
};

/// Whether the bias fields (smooth shading) of several scans are corrected.
enum class BiasFieldKind {
  Off,
  Auto, // where the scans agree better without it
  On
};

/// When learning rates drop under Schedule::Plateau.
struct PlateauRule {
  int patience = 10;       // iterations in which the mean loss has not improved on the best by `threshold`
  double factor = 0.5;     // factor by which the rates are multiplied
  double lowest = 0.01;    // the rates never fall below this share of the first ones
  double threshold = 1e-4; // relative improvement that counts
  bool operator==(const PlateauRule&) const = default;
};

/// Thresholds of pruning and densification, see Densify.h.
struct DensifyThresholds {
  std::optional<double> opacity; // τ_α: prunes below; 0.3 for alpha blending, 0.01 otherwise
  double size = 20;              // largest σ in voxels: prunes above
  double gradient = 1;           // τ_p: duplicates above this positional gradient
  double split = 2;              // τ_s on ‖Σ‖_F in voxels²: splits above, else clones
  bool operator==(const DensifyThresholds&) const = default;
};

/// All choices of a reconstruction; their meanings and ranges are in SettingsTable.cxx. The program chooses
/// unset optionals from the preset and the data (gap, thickness, noise).
struct Settings {
  Preset preset = Preset::Balanced;
  std::optional<Blending> blending;
  Selection selection = Selection::Exact;
  std::optional<double> cutoff; // Mahalanobis radius at which p reaches 0
  std::optional<bool> linearIntensity;
  std::optional<Initialisation> initialisation;
  std::optional<LossKind> loss;
  std::optional<double> lossWeight, ssimWeight; // of that loss, and of 1 − SSIM
  double huberDelta = 0.02;                     // normalised intensity
  std::optional<std::int64_t> gaussians;        // the budget: initial Gaussians of one member
  std::optional<std::int64_t> maxGaussians;     // limit for densification
  std::optional<int> iterations;                // over the data, per member
  std::optional<int> ensembleSize;              // fields fitted independently and merged (see Plan.h)
  std::optional<Schedule> schedule;
  PlateauRule plateau;
  std::optional<double> beta1, beta2; // Adam's decay rates of the moments
  std::optional<int> densifyEvery;    // iterations; 0: never
  DensifyThresholds densify;
  std::optional<bool> allAxes;
  std::optional<bool> paperStopRule; // stop when the loss fell by < 1e-4 over 100 iterations; 1000 at most
  bool relocate = true;              // has no effect with densification
  bool consistency = true;           // see addsResidual()
  PredictionKind prediction = PredictionKind::Auto;    // distant slices, normalised blending
  bool align = true;                                   // several scans: see Alignment/StackAlignment.h
  SliceMotionKind sliceMotion = SliceMotionKind::Auto; // several scans: see Alignment/SliceMotion.h
  bool acquiredPixels = true;                          // see Job/ScansAsAcquired.h
  bool ignorePadding = true;                           // see Acquisition/Padding.h and BlankSlices.h
  bool evenInterleaves = true;                         // see Acquisition/InterleaveGain.h
  bool blendEdges = true;                              // several scans: see Alignment/EdgeBlending.h
  std::optional<double> pixelWidth;                    // several scans: mm, see Stack
  int packets = 0;                                     // of slices that move together; 0: none do
  BiasFieldKind biasField = BiasFieldKind::Off;        // several scans: see Alignment/BiasCorrection.h
  bool keepBias = false;                               // with the bias field of the first scan
  bool n4 = false;                                     // needs ReconstructionInput::n4
  double fill = 0;                                     // scanner units
  int threads = 0;                                     // 0: all cores
  std::string instructionSet;                          // "": best available; "scalar": the plain reference
  std::string device = "auto";                         // "cpu", "cuda", "cuda:N"; auto: a GPU if the fit fits
  std::uint64_t seed = 1;

  // Only for dynamic scans (Motion/DynamicJob.h).
  std::optional<DynamicKind> kind;
  std::optional<int> knots;           // coefficients over the whole time
  std::optional<int> rounds;          // of the joint refinement
  std::optional<double> nodeDistance; // voxels
  std::optional<bool> sliceTiming;

  bool operator==(const Settings&) const = default;
};

/// The blending that results from these settings.
Blending chosenBlending(const Settings& settings);

/// Fills in the preset's values where nothing is set; values that depend on the data stay unset.
Settings withPresetValues(Settings settings);

/// Throws Error(InvalidArgument) with one sentence for a setting out of range.
void checkSettings(const Settings& settings);

} // namespace innergs
