#pragma once
#include "Core/Model/GaussianField.h"

#include <string>
#include <vector>

namespace innergs {

/// Where an interrupted fit stood; going on from it gives the same result as never having stopped.
struct Checkpoint {
  GaussianField field;
  std::vector<float> moment1,
      moment2; // Adam, 16 per Gaussian that is not finished; empty: the fit is complete
  std::vector<float>
      losses; // of every iteration of the open member: stop rule and plateau schedule look back
  std::vector<float> gradients; // per open Gaussian, since the last densification (Densify.h); may be empty
  std::int64_t finished = 0;    // the first Gaussians, of members already fitted
  int iteration = 0;            // iterations done, over all members
  std::string settingsKey;      // settings and input that the state belongs to
};

} // namespace innergs
