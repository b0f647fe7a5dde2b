#pragma once
#include "Core/Model/GaussianField.h"
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
  Adaptive, // density follows the image's structure
  Grid      // an even grid, as the paper's 42³
};
enum class Schedule {
  Exponential, // the learning rates decay to a fixed share over the iterations
  Plateau      // they are reduced whenever the loss stops improving
};

/// What the gaps of one scan of distant slices are filled with before Gaussians are fitted to slices and
/// filling together.
enum class PredictionKind {
  Auto,          // Learned
  None,          // nothing: the Gaussians bridge the gaps themselves
  Interpolation, // a mixture of classical interpolations, chosen by what the scan itself shows
  Learned // what is learned from the scan's own in-plane detail; where that does not pay, Interpolation
};

/// Whether every slice of several scans gets a rigid motion of its own.
enum class SliceMotionKind {
  Auto, // where the scans agree better with it
  On,
  Off
};

/// When learning rates drop under Schedule::Plateau.
struct PlateauRule {
  int patience = 10;       // iterations without a mean loss below the best so far by 1e-4 of it
  double factor = 0.5;     // what the rates are multiplied by
  double lowest = 0.01;    // share of the first rates that they never fall below
  double threshold = 1e-4; // relative improvement that counts
  bool operator==(const PlateauRule&) const = default;
};

/// Pruning and densification between two iterations, see Densify.h.
struct DensifyThresholds {
  std::optional<double> opacity; // τ_α: less is pruned; 0.3 for alpha blending, 0.01 for the others
  double size = 20;              // largest σ in voxels: more is pruned
  double gradient = 1;           // τ_p: above this positional gradient they become two
  double split = 2;              // τ_s on ‖Σ‖_F in voxels²: above, they are split, else cloned
  bool operator==(const DensifyThresholds&) const = default;
};

/// All choices of a reconstruction; SettingsTable.h says what each means and may be. Unset optionals are
/// chosen by the program from the preset and the data (gap, thickness, noise).
struct Settings {
  Preset preset = Preset::Balanced;
  std::optional<Blending> blending;
  Selection selection = Selection::Exact;
  std::optional<double> cutoff; // Mahalanobis radius at which p reaches 0
  std::optional<bool> linearIntensity;
  std::optional<Initialisation> initialisation;
  std::optional<LossKind> loss;
  std::optional<double> lossWeight, ssimWeight; // of that loss, and of 1 − SSIM beside it
  double huberDelta = 0.02;                     // normalised intensity
  std::optional<std::int64_t> gaussians;        // the budget: Gaussians of one member at its start
  std::optional<std::int64_t> maxGaussians;     // that densification may reach
  std::optional<int> iterations;                // over the data, per member
  std::optional<int> ensembleSize;              // fields fitted independently and merged (see Plan.h)
  std::optional<Schedule> schedule;
  PlateauRule plateau;
  std::optional<double> beta1, beta2; // Adam's shares of the old moments
  std::optional<int> densifyEvery;    // iterations; 0: never
  DensifyThresholds densify;
  std::optional<bool> allAxes;
  std::optional<bool> paperStopRule; // stop when the loss fell by < 1e-4 over 100 iterations; at most 1000
  bool relocate = true;              // not beside densification
  bool consistency = true;           // super-resolution only
  PredictionKind prediction = PredictionKind::Auto; // one scan of distant slices, normalised blending
  bool align = true;                                // several scans: see Alignment/StackAlignment.h
  SliceMotionKind sliceMotion = SliceMotionKind::Auto; // several scans: see Alignment/SliceMotion.h
  double fill = 0;                                  // scanner units
  int threads = 0;                                  // 0: all cores
  std::string instructionSet;                       // "": best available; "scalar": the plain reference
  std::string device = "auto";                      // "cpu", "cuda", "cuda:N"; auto: a GPU where the fit fits
  std::uint64_t seed = 1;
  bool operator==(const Settings&) const = default;
};

/// The blending that these settings lead to.
Blending chosenBlending(const Settings& settings);

/// With what the preset says filled in where nothing was set; what hangs on the data stays unset.
Settings withPresetValues(Settings settings);

/// Throws Error(InvalidArgument) with one sentence for a setting out of range.
void checkSettings(const Settings& settings);

} // namespace innergs
