#pragma once
#include <vector>

namespace innergs {

/// The state of the optimiser for the Gaussians still being fitted, apart from the Gaussians themselves.
struct OptimizerState {
  std::vector<float> moment1, moment2; // Adam's, 16 per Gaussian; empty: no fit in progress
  std::vector<float> losses;           // mean per sample and iteration: for stop rule and plateau schedule
  std::vector<float> gradients;        // sums per Gaussian since the last densification; may be empty
};

} // namespace innergs
