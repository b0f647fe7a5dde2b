#pragma once
#include "Core/Adam.h"

namespace innergs {

struct RelocationPlan {
  double share = 0.02; // of the Gaussians, at most
  double minLogScale = -10;
};

/// Moves the least useful Gaussians to where the residual is, within the same budget: those of least
/// contribution are dropped and those with the largest positional gradient (paper: ‖∇μ‖) are split in two
/// along their longest axis. Adam's moments of both restart at 0.
void relocateGaussians(GaussianField& field, Adam& adam, std::span<const float> gradient,
                       const RelocationPlan& plan, std::uint64_t seed);

} // namespace innergs
