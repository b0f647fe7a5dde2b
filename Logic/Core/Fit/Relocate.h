#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Initialise.h"

namespace innergs {

struct RelocationPlan {
  double share = 0.02; // of the Gaussians, maximum
  double minLogScale = -10;
};

/// Pruning and densification within a fixed budget, like the relocation in 3DGS-MCMC (Kheradmand et al.
/// 2024): drops the Gaussians with the weakest intensity gradient, and splits those with the strongest
/// positional gradient relative to their size (paper: ‖∇μ‖ above τ_p) along their longest axis. Adam's second
/// moments measure both; those of moved Gaussians restart at 0. Afterwards sorts the field along a Morton
/// curve.
void relocateGaussians(GaussianField& field, Adam& adam, const RelocationPlan& plan);

/// Reduces the field and Adam's moments to the Gaussians in `order`, in that order.
void takeInOrder(GaussianField& field, Adam& adam, std::span<const std::uint32_t> order);

} // namespace innergs
