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

/// When learning rates drop under Schedule::Plateau.
struct PlateauRule {
  int patience = 10;       // iterations without a mean loss below the best so far by 1e-4 of it
  double factor = 0.5;     // what the rates are multiplied by
  double lowest = 0.01;    // share of the first rates that they never fall below
  double threshold = 1e-4; // relative improvement that counts
};

/// Pruning and densification between two iterations, see Densify.h.
struct DensifyThresholds {
  std::optional<double> opacity; // τ_α: less is pruned; 0.3 for alpha blending, 0.01 for the others
  double size = 20;              // largest σ in voxels: more is pruned
  double gradient = 1;           // τ_p: Gaussians pulled harder become two
  double split = 2;              // τ_s on ‖Σ‖_F in voxels²: above, they are split, else cloned
};

/// All choices of a reconstruction. Unset optionals are chosen by the program from the preset and the data
/// (gap, thickness, noise).
struct Settings {
  Preset preset = Preset::Balanced;
  std::optional<Blending> blending; // normalised; preset Paper: alpha
  Selection selection = Selection::Exact;
  std::optional<double> cutoff; // Mahalanobis radius at which p reaches 0, 1 to 5: 2.2
  std::optional<bool> linearIntensity;
  std::optional<Initialisation> initialisation; // adaptive; preset Paper: grid
  std::optional<LossKind> loss;                 // L2; preset Paper: L1
  std::optional<double> pointWeight;            // weight of that loss: 1; preset Paper: 0.8
  std::optional<double> ssimWeight;             // weight of 1 − SSIM beside it: 0; preset Paper: 0.4
  double huberDelta = 0.02;                     // normalised intensity
  std::optional<std::int64_t> gaussians;        // the budget: Gaussians of one member at its start
  std::optional<std::int64_t> maxGaussians;     // that densification may reach; as many as at the start
  std::optional<int> iterations;                // iterations over the data, per member
  std::optional<int> ensembleSize;              // fields fitted independently and merged (see Plan.h)
  std::optional<Schedule> schedule;             // exponential; preset Paper: plateau
  PlateauRule plateau;
  std::optional<double> beta1, beta2; // Adam's shares of the old moments: 0.8, 0.95
  std::optional<int> densifyEvery;    // iterations; 0 = never, preset Paper: 10
  DensifyThresholds densify;
  std::optional<bool> allAxes; // fit the slices of one scan along all three of its axes; alpha: where its
                               // voxels are nearly cubes
  std::optional<bool> paperStopRule; // stop when the loss fell by < 1e-4 over 100 iterations; at most 1000
  bool relocate = true;    // even grid: prune useless Gaussians, split those under the residual; not beside
                           // densification
  bool consistency = true; // noise-aware data-consistency step after the fit (super-resolution only)
  double fill = 0;         // scanner units: the value outside the mask
  int threads = 0;         // 0 = all cores
  std::string instructionSet;  // "" = best available; "scalar" = the plain reference
  std::string device = "auto"; // "cpu", "cuda", "cuda:N"; auto: a GPU where one is found and the fit fits
  std::uint64_t seed = 1;
};

/// The blending that these settings lead to.
Blending chosenBlending(const Settings& settings);

/// Throws Error(InvalidArgument) with one sentence for a setting out of range.
void checkSettings(const Settings& settings);

} // namespace innergs
