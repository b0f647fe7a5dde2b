#pragma once
#include <vector>

namespace innergs {

/// What an optimiser knows of the Gaussians that it is still fitting, beside the Gaussians themselves.
struct OptimizerState {
  std::vector<float> moment1, moment2; // Adam's, 16 per Gaussian; empty: nothing is being fitted
  std::vector<float> losses;           // mean per sample, of every iteration: stop rule and plateau schedule
  std::vector<float> gradients;        // sums per Gaussian since the last densification; may be empty
};

} // namespace innergs
