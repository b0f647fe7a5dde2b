#pragma once
#include "Core/GaussianField.h"

#include <optional>
#include <string>

namespace innergs {

enum class Preset { Fast, Balanced, Best };
enum class LossKind { L1, L2, Huber };
enum class Initialisation {
  Adaptive, // density follows the image's structure
  Grid      // an even grid, as the paper's 42³
};

/// All choices of a reconstruction. Unset optionals are chosen by the program from the data (gap, thickness,
/// noise).
struct Settings {
  Preset preset = Preset::Balanced;
  Blending blending = Blending::Normalised;
  std::optional<bool> linearIntensity;
  Initialisation initialisation = Initialisation::Adaptive;
  LossKind loss = LossKind::L2;
  double huberDelta = 0.02;              // normalised intensity
  double ssimWeight = 0;                 // weight of 1 − SSIM beside the loss
  std::optional<std::int64_t> gaussians; // the budget
  std::optional<int> iterations;         // sweeps over the data, per member
  std::optional<int> members;            // fields fitted independently and merged (see Plan.h)
  bool paperStopRule = false; // stop when the loss fell by < 1e-4 over 100 iterations; at most 1000
  bool relocate = true;       // even grid: prune useless Gaussians, split those under the residual
  bool consistency = true;    // noise-aware data-consistency step after the fit (super-resolution only)
  int threads = 0;            // 0 = all cores
  std::string instructionSet; // "" = best available; "scalar" = the plain reference
  std::uint64_t seed = 1;
};

/// Throws Error(InvalidArgument) with one sentence for a setting out of range.
void checkSettings(const Settings& settings);

} // namespace innergs
