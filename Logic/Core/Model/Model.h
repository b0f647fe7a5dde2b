#pragma once
#include "Core/Model/GaussianField.h"
#include "Core/Model/OptimizerState.h"

#include <string>

namespace innergs {

/// A field and the state of its fit; resuming from it gives the same result as an uninterrupted fit.
struct Model {
  GaussianField field;
  std::int64_t finished = 0; // the first Gaussians, those of ensemble members already fitted
  int iteration = 0;         // iterations done, over all members
  OptimizerState optimizer;  // of the unfinished Gaussians
  std::string settingsKey;   // identifies the settings and input that the state belongs to

  /// True if nothing is left to optimise.
  bool complete() const { return optimizer.moment1.empty(); }
};

} // namespace innergs
