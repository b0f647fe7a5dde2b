#pragma once
#include "Core/Acquisition/Lattice.h"
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"
#include "Core/Render/Projection.h"

namespace innergs {

ProjectionFrame projectionFrame(const Lattice& lattice);

/// `values`: replaces intensity and slope when not empty.
void project(const GaussianField& field, std::span<const float> values, const Lattice& lattice,
             const ClosedFormPsf& psf, ThreadPool& pool, std::vector<Projected>& out,
             Selection selection = Selection::Exact);

/// How near the edge of the cut-off ellipsoid comes to any point of a lattice, in units of the exponent.
/// Gradients jump where a point enters it, so two devices that round otherwise may differ where it is next to
/// 0.
float edgeClearance(const Projected& gaussian, const Lattice& lattice);

} // namespace innergs
