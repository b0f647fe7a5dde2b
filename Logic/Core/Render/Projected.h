#pragma once
#include "Core/Acquisition/SampleGrid.h"
#include "Core/Render/GaussianBlocks.h"
#include "Core/Render/Projection.h"

namespace innergs {

ProjectionFrame projectionFrame(const SampleGrid& grid);

/// `values`: replaces intensity and slope if not empty.
void project(const GaussianField& field, std::span<const float> values, const SampleGrid& grid,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out,
             Selection selection = Selection::Exact);

/// Projected Gaussians of a field, in its order.
struct NearGaussians {
  std::vector<std::uint32_t> number; // in the field
  std::vector<Projected> projected;
};

/// The same for Selection::Exact, without Gaussians whose cut-off ellipsoids miss the grid's planes. Saves
/// time and memory on a grid that shows few of a field's Gaussians, such as a posed slice; more with blocks
/// that were measured on the same field.
void projectNear(const GaussianField& field, std::span<const float> values, const SampleGrid& grid,
                 const ClosedFormPsf& psf, ThreadPool& pool, NearGaussians& out,
                 const GaussianBlocks* blocks = nullptr);

/// The smallest distance between any point of a grid and the edge of the cut-off ellipsoid, in units of
/// the exponent. Gradients jump where a point crosses that edge, so devices with different rounding may
/// differ where the clearance is near 0.
float edgeClearance(const Projected& gaussian, const SampleGrid& grid);

} // namespace innergs
