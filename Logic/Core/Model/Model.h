#pragma once
#include "Core/Model/GaussianField.h"
#include "Core/Model/OptimizerState.h"

#include <string>

namespace innergs {

/// A field and where its fit stands; going on from there gives the same result as never having stopped.
struct Model {
  GaussianField field;
  std::int64_t finished = 0; // the first Gaussians, of ensemble members already fitted
  int iteration = 0;         // iterations done, over all members
  OptimizerState optimizer;  // of the Gaussians that are not finished
  std::string settingsKey;   // settings and input that the state belongs to

  /// Nothing is left to be optimised.
  bool complete() const { return optimizer.moment1.empty(); }
};

} // namespace innergs
