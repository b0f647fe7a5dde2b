#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Initialise.h"

namespace innergs {

struct RelocationPlan {
  double share = 0.02; // of the Gaussians, at most
  double minLogScale = -10;
};

/// Pruning and densification within one budget, as relocation in 3DGS-MCMC: Gaussians with the weakest
/// intensity gradient are dropped, and those with the strongest positional gradient relative to their size
/// (paper: ‖∇μ‖ above τ_p) are split in two along their longest axis. Adam's second moments measure both;
/// those of the moved ones restart at 0. Afterwards the field is sorted along a Morton curve.
void relocateGaussians(GaussianField& field, Adam& adam, const RelocationPlan& plan);

/// The field and Adam's moments become those of the Gaussians named, in that order.
void takeInOrder(GaussianField& field, Adam& adam, std::span<const std::uint32_t> order);

} // namespace innergs
