#pragma once
#include "Core/Fit/Adam.h"
#include "Core/Fit/Initialise.h"

namespace innergs {

struct RelocationPlan {
  double share = 0.02; // of the Gaussians, at most
  double minLogScale = -10;
};

/// Pruning and densification within one budget: Gaussians whose intensity the residual has hardly pulled at
/// are dropped, and those with the strongest positional gradient relative to their size (paper: ‖∇μ‖ above
/// τ_p) are split in two along their longest axis. Both are read off Adam's second moments; those of the
/// moved ones restart at 0. The field is sorted along a Morton curve afterwards.
void relocateGaussians(GaussianField& field, Adam& adam, const RelocationPlan& plan);

/// The field and Adam's moments become those of the Gaussians named, in that order.
void takeInOrder(GaussianField& field, Adam& adam, std::span<const std::uint32_t> order);

} // namespace innergs
