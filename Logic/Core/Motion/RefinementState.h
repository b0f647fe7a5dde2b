#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Motion/AdamBlock.h"

#include <functional>
#include <string>
#include <vector>

namespace innergs {

/// The state of a stopped joint refinement of all frames. Resumed from it and its field, the fit is
/// bit-identical to one without the stop.
struct RefinementState {
  int step = 0;               // done
  double mse = 0;             // running mean, normalised intensity²
  std::string key;            // of series and settings: settingsKey()
  std::vector<int> steps;     // of each of Adam's blocks
  std::vector<float> moments; // Adam's: first and second of the Gaussians, then of each block

  bool empty() const { return step == 0; }
};

/// Adam's state in a refinement: the canonical Gaussians' and blocks of whatever changes them.
struct RefinementOptimizer {
  Adam canonical{0};
  std::vector<AdamBlock> blocks;
  int step = 0; // done
  double mse = 0;

  void start(std::int64_t gaussians, std::vector<AdamBlock> blocks);
  RefinementState state() const;
  /// After start() with the same sizes. Throws Error(FileFormat) for a state of other sizes.
  void resume(const RefinementState& state);
  /// Adds a step's error to the running mean.
  void add(double error);
};

} // namespace innergs
